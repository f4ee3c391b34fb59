/*
 * types.c: prints the public structs and constants of the library in Fortran, for delassus.f90.
 * Runs when the library is built. Every component has a default of zero or null.
 */
#include <stdio.h>
#include <string.h>

#include "delassus/layout.h"

/* A type of layout.h in Fortran and its default. */
typedef struct types_row {
  const char *c, *fortran, *initial;
} types_row;

static const types_row types_table[] = {
    {"int", "integer(c_int)", "0"},
    {"long long", "integer(c_long_long)", "0"},
    {"size_t", "integer(c_size_t)", "0"},
    {"double", "real(c_double)", "0"},
    {"char", "character(kind=c_char)", "c_null_char"},
    {"pointer", "type(c_ptr)", "c_null_ptr"},
    {"function", "type(c_funptr)", "c_null_funptr"},
};

static int types_print_field(const dls_field *f) {
  const types_row *row = NULL;
  for (size_t k = 0; k < sizeof types_table / sizeof types_table[0]; k++)
    if (strcmp(f->type, types_table[k].c) == 0) row = &types_table[k];
  if (row)
    printf("    %s :: %s", row->fortran, f->name);
  else
    printf("    type(%s) :: %s", f->type, f->name);
  if (f->count > 1) printf("(%zu)", f->count);
  if (row) printf(" = %s", row->initial);
  putchar('\n');
  return ferror(stdout);
}

int main(void) {
  const dls_constant *c;
  const dls_field *f, *last = NULL;
  for (int k = 0; (c = dls_layout_constant(k)); k++)
    printf("  integer(c_int), parameter, public :: %s = %d\n", c->name, c->value);
  for (int k = 0; (f = dls_layout_field(k)); k++) {
    if (!*f->name && last) printf("  end type %s\n", last->record);
    if (!*f->name)
      printf("\n  type, public, bind(c) :: %s\n", f->record);
    else if (types_print_field(f))
      return 1;
    last = f;
  }
  if (last) printf("  end type %s\n", last->record);
  return fflush(stdout) != 0;
}
