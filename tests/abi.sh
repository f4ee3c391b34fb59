#!/bin/sh
# abi.sh BUILD [write]: compares what a compiled host relies on with the table tests/abi.txt: the functions that the shared
# libraries export with their prototypes, the sizes and fields of the public structs with their offsets, the values of
# the constants (x86-64). write: writes the table anew. A release that changes a line raises SOVERSION.
set -eu
build=$1
table=tests/abi.txt
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
[ "$(uname -m)" = x86_64 ] || { echo 'skipped: the table of the ABI is that of x86-64'; exit 0; }
cat > "$root/layout.c" << 'END'
#include <delassus/layout.h>
#include <stdio.h>
int main(void) {
  const dls_field *f;
  const dls_constant *c;
  for (int k = 0; (f = dls_layout_field(k)); k++)
    if (f->name[0])
      printf(", %s %s%s %zu", f->name, f->type, f->count > 1 ? "[]" : "", f->offset);
    else
      printf("%s%s: %zu", k ? "\n" : "", f->record, f->size);
  printf("\n");
  for (int k = 0; (c = dls_layout_constant(k)); k++)
    printf("%s%s %d", k % 8 ? ", " : k ? "\n" : "", c->name, c->value);
  printf("\n");
  return 0;
}
END
${CC:-cc} -Iinclude -o "$root/layout" "$root/layout.c" "$build/libdelassus.so" -Wl,-rpath,"$(realpath "$build")"
{
  echo "SOVERSION $(sed -n 's/^SOVERSION = //p' Makefile)"
  # "library: prototype" of each exported function
  for library in libdelassus libdelassus-files; do
    nm -D --defined-only "$build/$library.so" | sed -n "s/.* T \(dls_[a-z0-9_]*\).*/$library \1/p"
  done | LC_ALL=C sort > "$root/symbols"
  cat include/delassus/*.h | awk -v symbols="$root/symbols" '
    BEGIN { while ((getline line < symbols) > 0) { split(line, part, " "); library[part[2]] = part[1] } }
    /^DLS_API/ { text = ""; inside = 1 }
    inside { text = text " " $0 }
    inside && /;/ {
      inside = 0; gsub(/ +/, " ", text); gsub(/^ ?DLS_API |DLS_MUST_USE |;.*/, "", text)
      name = text; sub(/\(.*/, "", name); sub(/.*[ *]/, "", name)
      if (name in library) { print library[name] ": " text; delete library[name] }
    }
    END { for (name in library) print library[name] ": " name ", in no header" }' | LC_ALL=C sort
  "$root/layout"
} > "$root/table"
if [ "${2:-}" = write ]; then cp "$root/table" $table; fi
diff -u $table "$root/table" > "$root/diff" || { cat "$root/diff"
  echo 'check-abi: a host that was compiled before needs a new build: raise SOVERSION if its value was released, then make abi'; exit 1; }
echo "abi: $(wc -l < "$root/symbols") functions, $(grep -c '^dls_' $table) structs as in $table"
