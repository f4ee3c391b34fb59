# completion.bash: bash completion of delassus; the options come from --help.
_delassus() {
  local word=${COMP_WORDS[COMP_CWORD]} command=${COMP_WORDS[1]}
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W 'scene converge tables solve info chart profile map --help --version' -- "$word"))
  elif [[ $word == -* ]]; then
    COMPREPLY=($(compgen -W "$(delassus "$command" --help 2>/dev/null |
      grep -o -e '--[A-Za-z][A-Za-z-]*' | sort -u)" -- "$word"))
  elif [ "$command" = scene ]; then
    COMPREPLY=($(compgen -W "$(delassus scene --list 2>/dev/null | awk '{ print $1 }')" -- "$word"))
  else
    COMPREPLY=($(compgen -f -- "$word"))
  fi
}
complete -o filenames -F _delassus delassus
