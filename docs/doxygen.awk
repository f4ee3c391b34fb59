# doxygen.awk: a header as Doxygen reads it. The comment before a declaration becomes /** .. */, the comment behind a field
# /**< .. */, the first comment of the file its page. Indented lines of a comment stay as they are (formulas, tables); in
# the others characters that mean something to Doxygen are escaped. A declaration that follows another one without a blank
# line shares its comment.

function escape(s) {
  gsub(/\\/, "\\\\", s); gsub(/&/, "\\&amp;", s); gsub(/</, "\\&lt;", s); gsub(/>/, "\\&gt;", s)
  gsub(/@/, "\\@", s); gsub(/#/, "\\#", s); gsub(/\*/, "\\*", s); gsub(/%/, "%%", s); gsub(/~/, "\\~", s)
  gsub(/\[/, "\\[", s); gsub(/\|/, "\\&#124;", s); gsub(/`/, "\\`", s); gsub(/"/, "\\\"", s)
  # an underscore within a name stays: names of the library become links
  while (match(s, /(^|[^A-Za-z0-9_])_/)) s = substr(s, 1, RSTART + RLENGTH - 2) "&#95;" substr(s, RSTART + RLENGTH)
  gsub(/\.\./, "\\&#46;\\&#46;", s)
  if (s ~ /^[-+]/) s = "\\" s
  if (s ~ /^[0-9]*\./) sub(/\./, "\\&#46;", s)
  return links(s)
}

# functions become links by ()
function links(s,    out, name) {
  out = ""
  while (match(s, /dls_[a-z0-9_]+/)) {
    name = substr(s, RSTART, RLENGTH)
    out = out substr(s, 1, RSTART - 1) name
    s = substr(s, RSTART + RLENGTH)
    if ((name in is_function) && s !~ /^\(/) out = out "()"
  }
  return out s
}
BEGIN {
  while (("grep -ho 'dls_[a-z0-9_]*(' include/delassus/*.h" | getline name) > 0) is_function[substr(name, 1, length(name) - 1)]
}

# text: the lines of a comment without its marks; prints them in `open` .. */
function emit(open,    k, out, code, line) {
  out = open
  code = 0
  for (k = 1; k <= count; k++) {
    line = text[k]
    if (line ~ /^ / && line !~ /^ *$/) {
      if (!code) out = out "\n\\verbatim"
      code = 1
      out = out "\n" line
    } else if (line ~ /^ *$/) {
      # blank lines inside a formula stay in it
      if (code && k < count && text[k + 1] ~ /^ /) out = out "\n"
      else { if (code) out = out "\n\\endverbatim"; code = 0; out = out "\n" }
    } else {
      if (code) out = out "\n\\endverbatim"
      code = 0
      out = out (k == 1 ? " " : "\n") escape(line)
    }
  }
  if (code) out = out "\n\\endverbatim\n"
  return out " */"
}

function take(line, is_first) {
  sub(/\*\/ *$/, "", line)
  if (is_first) sub(/^ *\/\* ?/, "", line)
  else if (indent) { sub(/^ *\*? ?/, "", line); sub(/^ +/, "", line) }
  else sub(/^ \*( |$)/, "", line)
  sub(/ +$/, "", line)
  text[++count] = line
}

# a comment alone on its lines
!inside && /^ *\/\*/ {
  indent = match($0, /[^ ]/) - 1
  if ($0 ~ /^\/\* ----/) { shared = ""; print ""; next }
  inside = 1
  count = 0
  take($0, 1)
  if ($0 ~ /\*\/ *$/) { inside = 0; finish() }
  next
}
inside == 1 {
  take($0, 0)
  if ($0 ~ /\*\/ *$/) { inside = 0; finish() }
  next
}
function finish(    k) {
  if (!had_file) {
    had_file = 1
    while (count && text[1] == "") { for (k = 1; k < count; k++) text[k] = text[k + 1]; count-- }
    sub(/^delassus\/[a-z]+\.h: */, "", text[1])
    sub(/^delassus\.h: */, "", text[1])
    text[1] = toupper(substr(text[1], 1, 1)) substr(text[1], 2)
    print emit("/** \\file\n")
    return
  }
  last = emit("/**")
  shared = indent ? "" : last
  print last
  fresh = 1
}
# a comment behind a field or an enumerator, which may go on below
!inside && /[;,{}a-zA-Z0-9] *\/\*/ && !/^#/ {
  at = index($0, "/*")
  code = substr($0, 1, at - 1)
  rest = substr($0, at)
  count = 0
  indent = 1
  if (rest ~ /\*\/ *$/ || index(rest, "*/")) {
    end = index(rest, "*/")
    after = substr(rest, end + 2)
    take(substr(rest, 1, end + 1), 1)
    if (after ~ /[a-zA-Z]/ || code ~ /\(/) { print code after; next } # between words
    print code emit("/**<") after
    next
  }
  take(rest, 1)
  inside = 2
  next
}
inside == 2 {
  take($0, 0)
  if ($0 ~ /\*\/ *$/) { inside = 0; print code emit("/**<") }
  next
}
/^ *$/ { shared = ""; fresh = 0 }
# the second of several declarations under one comment
/^DLS_API/ && !fresh && shared != "" { print shared }
/^DLS_API/ { fresh = 0 }
{ print }
