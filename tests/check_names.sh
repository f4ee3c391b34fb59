#!/bin/sh
# check_names.sh [DIRECTORY]: five rules on the files of the tree at DIRECTORY (here). Reports FILE:LINE.
#
#   1 no static function name but main stands in three or more files: a name leads to one place
#   2 no function of the library but dlsi_at has a parameter `const char *function`: errors get their
#     name at the door
#   3 no line is longer than 100 columns
#   4 a public function with an error begins with DLSI_DOOR, which keeps the host's floating point environment
#   5 no class of a Python file has a test twice: the first would never run
cd "${1:-.}" || exit 2
find src tests bench examples -name '*.py' | LC_ALL=C xargs awk '
  /^class / { class = $2 }
  /^    def test_/ && seen[FILENAME, class, $2]++ { print FILENAME ":" FNR ": a second " $2; bad = 1 }
  END { exit bad }' || exit 1
find include src lcp vi reduction global tests bench examples -name '*.[ch]' | sort | LC_ALL=C xargs awk '
  function report(text) { print text; bad = 1 }
  FNR == 1 { declaration = "" }
  length($0) > 100 { report(FILENAME ":" FNR ": " length($0) " columns") }

  # a declaration or definition begins in the first column; remember its name for the lines that follow
  /^[a-z]/ { declaration = $0; sub(/\(.*/, "", declaration); sub(/.*[ *]/, "", declaration) }
  /const char \*function *[,)]/ && declaration != "dlsi_at" && FILENAME !~ /^tests\// {
    report(FILENAME ":" FNR ": parameter `function` of " declaration)
  }
  # the line after a public function of the library
  door { if ($0 !~ /^  DLSI_DOOR;/) report(FILENAME ":" FNR ": no DLSI_DOOR in " declaration); door = 0 }
  /^[a-z][^=;]* \**dls_[a-z0-9_]+\(/ && FILENAME ~ /^(src\/|lcp|vi|reduction|global)/ && FILENAME !~ /cli|fortran|_none/ {
    text = ""; inside = 1
  }
  inside { text = text $0 }
  inside && /[;{]$/ { door = /{$/ && text ~ /dls_error \*error/ && text !~ /^static/; inside = 0 }
  /^static [^=]*[A-Za-z0-9_]\(/ && declaration != "main" && !((declaration, FILENAME) in seen) {
    seen[declaration, FILENAME] = 1
    files[declaration]++
    places[declaration] = places[declaration] "\n  " FILENAME ":" FNR
  }
  END {
    for (name in files)
      if (files[name] > 2) report("static " name " stands in " files[name] " files:" places[name])
    if (!bad) print "names: no static name in three files, none of a function passed down, 100 columns, doors"
    exit bad
  }'
