#!/bin/sh
# man.sh 1|3 PROGRAM: prints a man page of the program made of its --help, or of the library made of the
# first comments of its headers, so that neither can differ from them.
set -eu
section=$1
program=$2
version=$("$program" --version | sed 's/.* //')
# literal text: backslashes, and dots and quotes at the start of a line
literal() {
  sed -e 's/\\/\\e/g' -e "s/^\([.']\)/\\\\\&\1/" -e 's/-/\\-/g'
}
echo ".TH DELASSUS $section \"\" \"delassus $version\" \"delassus\""
if [ "$section" = 1 ]; then
  printf '%s\n' '.SH NAME' 'delassus \- solves discrete contact problems with dry friction' '.SH SYNOPSIS' '.nf'
  "$program" --help | sed -n 's/^Usage: //p' | literal
  printf '%s\n' '.fi' '.SH DESCRIPTION' '.nf'
  "$program" --help | sed 1d | literal
  echo .fi
  for command in solve info scene converge tables chart profile map; do
    echo ".SH DELASSUS $command" | tr a-z A-Z
    echo .nf
    "$program" $command --help | literal
    echo .fi
  done
  echo '.SH FCLIB FILES'
  echo .nf
  sed -n '/^## FCLIB/,/^## /{/^## /d;/^```/d;p;}' docs/files.md | literal
  echo .fi
  printf '%s\n' '.SH ENVIRONMENT' '.TP' '.B NO_COLOR' 'If it is set and not empty, the last line is not coloured on a terminal.' \
    '.SH EXIT STATUS' '0 solved, 1 not solved, 2 bad input; the last line on stdout says it in words.'
  printf '%s\n' '.SH SEE ALSO' '.BR delassus (3),' 'files.md in the documentation: what each file must hold.'
else
  printf '%s\n' '.SH NAME' 'delassus \- library for discrete contact with dry friction' '.SH SYNOPSIS' '.nf' \
    '#include <delassus.h>' '' 'cc ... $(pkg\-config \-\-cflags \-\-libs delassus)' '.fi' '.SH DESCRIPTION' \
    'Each header is the manual of its functions; files.h is in libdelassus\-files. The first comment of each:'
  for header in include/delassus.h include/delassus/*.h; do
    echo ".SS ${header#include/}" | sed 's/-/\\-/g'
    echo .nf
    awk '/^\/\*/ { on = 1 } on { print } /\*\// && on { exit }' "$header" |
      sed -e 's|^/\* \{0,1\}||' -e 's| *\*/$||' -e 's/^ \* \{0,1\}//' -e '/^$/{1d;}' | literal
    echo .fi
  done
  printf '%s\n' '.SH SEE ALSO' '.BR delassus (1)'
fi
