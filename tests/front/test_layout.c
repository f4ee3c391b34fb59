/* test_layout.c: the table of layouts misses no field; fresh settings are the headers' defaults. */
#include "delassus.h"
#include "run.h"

/* Returns the row of a whole struct, -1 if there is none. */
static int row_of(const char *record) {
  const dls_field *f;
  for (int k = 0; (f = dls_layout_field(k)); k++)
    if (!*f->name && strcmp(f->record, record) == 0) return k;
  return -1;
}

static size_t size_of_type(const char *type);

/* Returns the alignment of a type: of a struct the largest of its fields. */
static size_t alignment(const char *type) {
  const dls_field *f;
  size_t most = 1;
  if (strncmp(type, "dls_", 4) != 0) return size_of_type(type);
  const int row = row_of(type);
  ck_assert_msg(row >= 0, "no row of %s", type);
  for (int k = row + 1; (f = dls_layout_field(k)) && *f->name; k++) {
    const size_t own = alignment(f->type);
    if (own > most) most = own;
  }
  return most;
}

static size_t size_of_type(const char *type) {
  if (strcmp(type, "char") == 0) return 1;
  if (strcmp(type, "int") == 0) return sizeof(int);
  if (strcmp(type, "size_t") == 0) return sizeof(size_t);
  if (strcmp(type, "long long") == 0) return sizeof(long long);
  if (strcmp(type, "double") == 0) return sizeof(double);
  if (strcmp(type, "pointer") == 0) return sizeof(void *);
  if (strcmp(type, "function") == 0) return sizeof(dls_solve_fn);
  const int row = row_of(type);
  ck_assert_msg(row >= 0, "no row of %s", type);
  return dls_layout_field(row)->size;
}

/* Each field begins where the one before ends, but for alignment; so does the end of the struct. */
TEST(every_byte_of_every_struct_has_a_field) {
  const dls_field *f;
  int records = 0;
  size_t at = 0;
  for (int k = 0; (f = dls_layout_field(k)); k++) {
    if (!*f->name) {
      records++;
      at = 0;
      ck_assert_int_eq(row_of(f->record), k);
      continue;
    }
    const size_t a = alignment(f->type);
    ck_assert_msg(f->offset == (at + a - 1) / a * a, "before %s.%s", f->record, f->name);
    ck_assert_uint_eq(f->size, f->count * size_of_type(f->type));
    at = f->offset + f->size;
    const dls_field *next = dls_layout_field(k + 1);
    if (next && *next->name) continue;
    const size_t whole = alignment(f->record), size = size_of_type(f->record);
    ck_assert_msg(size == (at + whole - 1) / whole * whole, "at the end of %s", f->record);
  }
  ck_assert_int_gt(records, 0);
}

TEST(a_struct_comes_after_those_that_it_contains) {
  const dls_field *f;
  for (int k = 0; (f = dls_layout_field(k)); k++)
    if (*f->name && strncmp(f->type, "dls_", 4) == 0) {
      ck_assert_int_ge(row_of(f->type), 0);
      ck_assert_int_lt(row_of(f->type), row_of(f->record));
    }
}

#define EXPECT(s, f, text)                                                                         \
  do {                                                                                             \
    const dls_field *row = NULL;                                                                   \
    for (int k = 0; (row = dls_layout_field(k)); k++)                                              \
      if (!strcmp(row->record, #s) && !strcmp(row->name, #f)) break;                               \
    ck_assert_msg(row != NULL, "no row of " #s "." #f);                                            \
    ck_assert_uint_eq(row->offset, offsetof(s, f));                                                \
    ck_assert_uint_eq(row->size, sizeof(((s *)0)->f));                                             \
    ck_assert_str_eq(row->type, text);                                                             \
  } while (0)

TEST(fields_of_each_kind_are_told) {
  EXPECT(dls_error, status, "int");
  EXPECT(dls_error, index, "long long");
  EXPECT(dls_error, message, "char");
  EXPECT(dls_limits, progress, "function");
  EXPECT(dls_model, solve, "function");
  EXPECT(dls_model, active, "pointer");
  EXPECT(dls_dense, ld, "int");
  EXPECT(dls_contact, Wb, "dls_blocks");
  EXPECT(dls_info, stage, "dls_stage");
  EXPECT(dls_solver_settings, size, "size_t");
  EXPECT(dls_motion_energies, scale, "double");
  EXPECT(dls_diagnosis, wedged, "dls_flaw");
}

/* ---- defaults -------------------------------------------------------------------------------- */

/* Compares two structs field by field, since bytes between fields have any value. */
static void expect_fields(const char *record, const char *own, const char *wanted) {
  const dls_field *f;
  const int row = row_of(record);
  ck_assert_msg(row >= 0, "no row of %s", record);
  for (int k = row + 1; (f = dls_layout_field(k)) && *f->name; k++)
    if (strncmp(f->type, "dls_", 4) == 0)
      expect_fields(f->type, own + f->offset, wanted + f->offset);
    else
      ck_assert_msg(memcmp(own + f->offset, wanted + f->offset, f->size) == 0, "%s.%s", record,
                    f->name);
}

/* Fills settings, of bytes that are no defaults, and compares them with the fields given here, all
 * others being 0. */
#define FRESH(name, ...)                                                                           \
  do {                                                                                             \
    dls_##name##_settings own;                                                                     \
    const dls_##name##_settings wanted = {.size = sizeof own, __VA_ARGS__};                        \
    memset(&own, 0x55, sizeof own);                                                                \
    dls_##name##_settings_init(&own);                                                              \
    expect_fields("dls_" #name "_settings", (const char *)&own, (const char *)&wanted);            \
  } while (0)

TEST(fresh_settings_are_those_of_the_headers) {
  const dls_limits usual = {.tol = 1e-8, .threads = 1};
  FRESH(solver, .limits = usual, .method = DLS_AUTO);
  FRESH(admm, .limits = usual, .rho = 1);
  FRESH(augmented, .limits = usual, .factor = 100, .adaptive = 1);
  FRESH(newton, .limits = usual, .sweeps = 20, .regularization = 1e-6);
  FRESH(nlgs, .limits = usual, .relaxation = 1, .window = 10);
  FRESH(primal, .limits = usual, .relaxation = 1, .aitken = 1);
  FRESH(lemke, .limits = usual, .crash = 1);
  FRESH(principal, .limits = usual, .block_steps = 10);
  FRESH(reduction, .loads = 1, .form_W = 1);
  FRESH(motion, .limits = {.tol = 1e-12, .warm_start = 1, .threads = 1}, .law = DLS_MOTION_VELOCITY,
        .method = DLS_AUTO, .theta = 0.5, .forecast = 0.5);
}

/* ---- constants ------------------------------------------------------------------------------- */

/* Returns the value of a constant, 12345 if there is none of the name. */
static int value_of(const char *name) {
  const dls_constant *c;
  for (int k = 0; (c = dls_layout_constant(k)); k++)
    if (strcmp(c->name, name) == 0) return c->value;
  return 12345;
}

TEST(constants_have_their_values) {
  ck_assert_int_eq(value_of("DLS_OK"), DLS_OK);
  ck_assert_int_eq(value_of("DLS_E_CALLBACK"), DLS_E_CALLBACK);
  ck_assert_int_eq(value_of("DLS_E_BUSY"), DLS_E_BUSY);
  ck_assert_int_eq(value_of("DLS_E_NO_DERIVATIVE"), DLS_E_NO_DERIVATIVE);
  ck_assert_int_eq(value_of("DLS_LDLT"), DLS_LDLT);
  ck_assert_int_eq(value_of("DLS_HOMOTOPY"), DLS_HOMOTOPY);
  ck_assert_int_eq(value_of("DLS_STAGES_MAX"), DLS_STAGES_MAX);
}

TEST(numbers_outside_give_null) {
  ck_assert_ptr_null(dls_layout_field(-1));
  ck_assert_ptr_null(dls_layout_field(100000));
  ck_assert_ptr_null(dls_layout_constant(-1));
  ck_assert_ptr_null(dls_layout_constant(100000));
}
