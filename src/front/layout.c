/*
 * layout.c: gives other languages the layouts of the public structs. layout.awk writes the lists of
 * names from the headers when the library is built; the compiler adds offsets, sizes and types.
 */
#include "delassus/layout.h"

#include "delassus.h"
#include "layout.inc"

/* Names of types; an enum is int or unsigned. */
/* clang-format off */
#define FUNCTION(f) f: "function",
#define RECORD(s)   s: #s,
#define TYPE(x)                                                                                    \
  _Generic((x), LAYOUT_FUNCTIONS LAYOUT_RECORDS int: "int", unsigned: "int", double: "double",     \
           char: "char", long long: "long long", default: "pointer")
/* clang-format on */

#define AT(s, f)    (((s *)0)->f) /* never evaluated */
#define WHOLE(s)    {#s, "", #s, 0, sizeof(s), 1},
#define FIELD(s, f) {#s, #f, TYPE(AT(s, f)), offsetof(s, f), sizeof AT(s, f), 1},
#define SIZE(s, f)  {#s, #f, "size_t", offsetof(s, f), sizeof AT(s, f), 1},
#define ARRAY(s, f)                                                                                \
  {#s,                                                                                             \
   #f,                                                                                             \
   TYPE(AT(s, f)[0]),                                                                              \
   offsetof(s, f),                                                                                 \
   sizeof AT(s, f),                                                                                \
   sizeof AT(s, f) / sizeof AT(s, f)[0]},
#define CONSTANT(c) {#c, c},

static const dls_field layout_fields[] = {LAYOUT_FIELDS};
static const dls_constant layout_constants[] = {LAYOUT_CONSTANTS};

enum {
  layout_field_count = sizeof layout_fields / sizeof layout_fields[0],
  layout_constant_count = sizeof layout_constants / sizeof layout_constants[0]
};

const dls_field *dls_layout_field(int k) {
  return k >= 0 && k < layout_field_count ? &layout_fields[k] : NULL;
}

const dls_constant *dls_layout_constant(int k) {
  return k >= 0 && k < layout_constant_count ? &layout_constants[k] : NULL;
}
