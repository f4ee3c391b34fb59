# layout.awk: lists the structs, fields, function types and enumerators of the public headers that
# it is given, as macros for layout.c, so that no table has to follow the headers by hand.

# drop comments and directives, join the lines of all files
{
  line = $0
  if (inside) { if (!sub(/^.*\*\//, "", line)) next; inside = 0 }
  gsub(/\/\*([^*]|\*+[^*\/])*\*+\//, "", line)
  if (match(line, /\/\*/)) { line = substr(line, 1, RSTART - 1); inside = 1 }
  if (line !~ /^#/) text = text " " line
}

# "double *a, b[3]" -> rows of macros
function declare(record, declaration,   n, part, k, field, array, macro) {
  n = split(declaration, part, ",")
  for (k = 1; k <= n; k++) {
    field = part[k]
    array = field ~ /\[/
    sub(/ *\[.*/, "", field); gsub(/ +$/, "", field); sub(/.*[ *]/, "", field)
    # where size_t is unsigned, _Generic does not know it from an enum
    macro = array ? "ARRAY" : declaration ~ /^ *size_t [^*]*$/ ? "SIZE" : "FIELD"
    if (field != "") fields = fields " \\\n  " macro "(" record ", " field ")"
  }
}

# A struct comes after those that it contains by value.
function visit(record,   k, n, part) {
  if (record in done) return
  done[record] = 1
  for (k = 1; k <= count; k++) if (body[record] ~ name[k] " [a-zA-Z]") visit(name[k])
  records = records " \\\n  RECORD(" record ")"
  fields = fields " \\\n  WHOLE(" record ")"
  n = split(body[record], part, ";")
  for (k = 1; k < n; k++) declare(record, part[k])
}

END {
  gsub(/[ \t]+/, " ", text)
  rest = text
  while (match(rest, /typedef int \(\*dls_[a-z_]+\)/)) {
    one = substr(rest, RSTART, RLENGTH); gsub(/typedef int \(\*|\)/, "", one)
    functions = functions " \\\n  FUNCTION(" one ")"
    rest = substr(rest, RSTART + RLENGTH)
  }
  rest = text
  while (match(rest, /typedef struct dls_[a-z0-9_]+ \{[^}]*\}/)) {
    one = substr(rest, RSTART, RLENGTH); rest = substr(rest, RSTART + RLENGTH)
    record = one; sub(/typedef struct /, "", record); sub(/ .*/, "", record)
    sub(/[^{]*\{/, "", one); sub(/\}/, "", one)
    name[++count] = record; body[record] = one
  }
  for (i = 1; i <= count; i++) visit(name[i])
  rest = text
  while (match(rest, /enum [a-z_ ]*\{[^}]*\}/)) {
    one = substr(rest, RSTART, RLENGTH); rest = substr(rest, RSTART + RLENGTH)
    sub(/[^{]*\{/, "", one); sub(/\}/, "", one)
    n = split(one, enumerator, ",")
    for (i = 1; i <= n; i++) {
      one = enumerator[i]; sub(/=.*/, "", one); gsub(/ /, "", one)
      if (one != "") constants = constants " \\\n  CONSTANT(" one ")"
    }
  }
  print "#define LAYOUT_FUNCTIONS" functions "\n"
  print "#define LAYOUT_RECORDS" records "\n"
  print "#define LAYOUT_FIELDS" fields "\n"
  print "#define LAYOUT_CONSTANTS" constants
}
