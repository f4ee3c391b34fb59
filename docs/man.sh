#!/bin/sh
# man.sh PAGE PROGRAM: prints the man page delassus.1, delassus-COMMAND.1, delassus-mpi.1 or delassus.3. They are made of the program's
# --help, of docs/program.md (summaries and examples, which make check-docs runs), of docs/files.md and of the comments of
# the headers, so that none can differ from these.
set -eu
page=$1
program=$2
version=$("$program" --version | sed 's/.* //')
commands=$("$program" help commands)

# literal text: backslashes, and dots and quotes at the start of a line
literal() {
  sed -e 's/\\/\\e/g' -e "s/^\([.']\)/\\\\\&\1/" -e 's/-/\\-/g'
}
head() { # title, section, name, summary
  echo ".TH $(echo "$1" | tr a-z A-Z) $2 \"\" \"delassus $version\" \"delassus\""
  printf '%s\n' '.SH NAME' "$(echo "$3" | literal) \\- $4"
}
summary() { # command
  sed -n "s/^| \`$1\` | \(.*\) |\$/\1/p" docs/program.md | sed 's/`//g' | literal
}
# examples COMMAND [MOST]: its lines in docs/program.md
examples() {
  sed -n "s/^\(delassus $1 .*\)/\1/p; s/^\(delassus $1\)\$/\1/p" docs/program.md | sed "${2:-100}q" | literal |
    awk '{ at = index($0, "  #"); command = at ? substr($0, 1, at - 1) : $0; sub(/ *$/, "", command)
           words = at ? substr($0, at) : ""; sub(/^ *# */, "", words)
           print ".TP\n.B " command; if (words != "") print words; else print "\\&" }'
}
# options: --help as paragraphs and a list of options; the lines of usage are left out
options() {
  sed '/^Usage:/d; /^  or:/d; /^Exit status:/d' | literal | awk '
    function open(list) { if (list != mode) { if (mode == "nf") print ".fi"; if (list == "nf") print ".nf"; mode = list } }
    /^ *\\-/ { open("")
      text = $0; sub(/^ */, "", text)
      at = match(text, /   *[^ ]/)
      name = at ? substr(text, 1, at - 1) : text
      words = at ? substr(text, at) : ""; sub(/^ */, "", words)
      print ".TP\n.B " name; if (words != "") print words
      in_option = 1; next }
    in_option && /^                    / { sub(/^ */, ""); print; next }
    { blank = before == ""; before = $0 }
    /^$/ { in_option = 0; open(""); print ".PP"; next }
    /^  / { in_option = 0; open("nf"); print; next }
    blank && /:$/ && length($0) < 60 { in_option = 0; open(""); sub(/:$/, ""); print ".SS " $0; next }
    { in_option = 0; open(""); print }
    END { open("") }'
}
usage() {
  sed -n 's/^Usage: //p; s/^  or: *//p' | literal | sed 's/^/.br\n/' | sed 1d
}
ends() { # see also; --help on standard input
  echo '.SH EXIT STATUS'
  sed -n 's/^Exit status: //p' | literal
  printf '%s\n' 'The last line on standard output says it in words.' '.SH SEE ALSO' "$1"
}

case $page in
delassus.1)
  head delassus 1 delassus 'solves contact problems with Coulomb friction'
  echo .SH SYNOPSIS
  "$program" --help | usage
  printf '%s\n' '.SH DESCRIPTION' '.B delassus' 'solves problems of unilateral contact with Coulomb friction, from files or from the' \
    'matrices of another code, runs benchmark scenes, and compares methods.' \
    'Each answer has a certificate, a residual that is computed again from the data.' '.SH COMMANDS'
  for command in $commands; do
    printf '.TP\n.BR delassus\\-%s (1)\n%s\n' "$command" "$(summary "$command")"
  done
  printf '%s\n' '.TP' '.B delassus help \fR[\fPCOMMAND\fR | methods | scenes]' 'prints options, the names of methods, or those of scenes.'
  echo .SH EXAMPLES
  for command in $commands; do
    examples "$command" 1
  done
  printf '%s\n' '.SH ENVIRONMENT' '.TP' '.B TMPDIR' 'where chart, map, profile and report make a folder without \-\-out; /tmp if it is not set.' \
    '.TP' '.B NO_COLOR' 'If it is set and not empty, the last line is not coloured on a terminal.' \
    '.TP' '.B OPENBLAS_NUM_THREADS' 'threads of the BLAS, which large problems use.'
  "$program" --help | ends "$(printf '.BR delassus\\-%s (1),\n' $commands; echo '.BR delassus (3)')" ;;
delassus-mpi.1) # PROGRAM-mpi
  head delassus-mpi 1 delassus-mpi 'solves contact problems with Coulomb friction on several processes'
  echo .SH SYNOPSIS
  "$program-mpi" --help | usage
  echo .SH DESCRIPTION
  "$program-mpi" --help | options
  echo .SH EXAMPLES
  sed -n 's/^\(mpirun .*\)build\/\(delassus-mpi.*\)/\1\2/p' docs/mpi.md | literal | sed 's/^/.TP\n.B /; s/$/\n\\\&/'
  "$program-mpi" --help | ends '.BR delassus (1)' ;;
delassus-*.1)
  command=${page#delassus-}
  command=${command%.1}
  head "delassus-$command" 1 "delassus-$command" "$(summary "$command")"
  echo .SH SYNOPSIS
  "$program" "$command" --help | usage
  echo .SH DESCRIPTION
  "$program" "$command" --help | options
  if [ "$command" = solve ]; then
    printf '%s\n' '.SH FCLIB FILES' .nf
    sed -n '/^## FCLIB/,/^## /{/^## /d;/^```/d;p;}' docs/files.md | literal
    echo .fi
  fi
  echo .SH EXAMPLES
  examples "$command"
  "$program" "$command" --help | ends '.BR delassus (1)' ;;
delassus.3)
  head delassus 3 delassus 'library for contact with Coulomb friction'
  printf '%s\n' '.SH SYNOPSIS' '.nf' '#include <delassus.h>' '' 'cc ... $(pkg\-config \-\-cflags \-\-libs delassus)' '.fi' \
    '.SH DESCRIPTION' 'This is an index of all functions. The headers describe their arguments, units and errors; the guide' \
    'has them with a search. files.h is in libdelassus\-files, fe.h, forming.h and moving.h are in' \
    'libdelassus\-fe, mpi.h is in libdelassus\-mpi.'
  for header in $(sed -n 's/^.include "\(delassus.*\)"/\1/p' include/delassus.h) delassus/fe.h delassus/forming.h \
    delassus/moving.h delassus/mpi.h; do
    echo ".SH $header" | literal | sed 's/^\\&//'
    # first sentence of the comment before each function; a function without a blank line before it shares the comment
    awk '
      function sentence(s,    at) {
        gsub(/[ \t]+/, " ", s); sub(/^ /, "", s)
        at = match(s, /\. |\.$/)
        return at ? substr(s, 1, at) : s
      }
      !file && /\*\// { file = 1; next }
      !file { next }
      /^\/\*/ { comment = ""; on = 1 }
      on { line = $0; last = line ~ /\*\//; sub(/^ ?\/?\*+ ?/, "", line); sub(/\*\/.*/, "", line); comment = comment " " line
           if (last) on = 0; next }
      /^$/ { comment = "" }
      /^DLS_API/ { declaration = $0; while (declaration !~ /\(/) { getline; declaration = declaration $0 }
        match(declaration, /dls_[a-z0-9_]+\(/)
        print ".TP\n.B " substr(declaration, RSTART, RLENGTH) ")\n" sentence(comment) }' "include/$header" |
      sed -e 's/\\/\\e/g' -e "/^\.TP\$\|^\.B dls/!s/^\([.']\)/\\\\\&\1/" -e 's/-/\\-/g'
  done
  printf '%s\n' '.SH SEE ALSO' '.BR delassus (1)' ;;
*)
  echo "man.sh: $page is none of delassus.1, delassus-COMMAND.1, delassus.3" >&2
  exit 2 ;;
esac
