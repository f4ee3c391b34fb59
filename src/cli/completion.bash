# completion.bash: bash completion of delassus: commands, options (from --help), methods, scenes, files.
_delassus() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]} names= scene=
  [ "$before" = = ] && before=${COMP_WORDS[COMP_CWORD-2]}
  if [ "$word" = = ]; then before=${COMP_WORDS[COMP_CWORD-1]} word=; fi
  if [ "$COMP_CWORD" -eq 1 ]; then
    names="$(delassus help commands 2>/dev/null) help --help --version"
  else
    case $before in
    -m | --method) names="$(delassus help methods 2>/dev/null | cut -d' ' -f1) gauss-seidel" ;;
    -a | --accel) names='none aitken anderson momentum' ;;
    --law) names='velocity gap path' ;;
    --on) names='W K' ;;
    --against) names='condition rank skew mesh' ;;
    *)
      if [[ $word == -* ]]; then
        [[ ${COMP_WORDS[2]} == -* ]] || scene=${COMP_WORDS[2]}
        names=$(delassus "$command" $scene --help 2>/dev/null | grep -o -e '--[A-Za-z][A-Za-z-]*')
      else
        case $command in
        scene) names=$(delassus help scenes 2>/dev/null | cut -d' ' -f1) ;;
        solve | info | chart | map | profile | report | study) names=$(delassus help scenes 2>/dev/null | cut -d' ' -f1) ;;
        help) names="$(delassus help commands 2>/dev/null) methods scenes" ;;
        esac
      fi ;;
    esac
  fi
  COMPREPLY=($(compgen -W "$names" -- "$word" | sort -u))
  case $before in -m | --method | -a | --accel) return ;; esac
  [[ $word == -* || $COMP_CWORD -eq 1 ]] || COMPREPLY+=($(compgen -f -- "$word"))
}
complete -o filenames -F _delassus delassus
