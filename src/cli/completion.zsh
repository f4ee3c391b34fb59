#compdef delassus
# completion.zsh: zsh completion of delassus: commands, options (from --help), methods, scenes, files.
_delassus() {
  local command=${words[2]} before=${words[CURRENT-1]} word=${words[CURRENT]}
  local -a names
  if (( CURRENT == 2 )); then
    names=(${(f)"$(delassus help commands 2>/dev/null)"} help --help --version)
    compadd -a names
    return
  fi
  # --method=WORD is one word here
  if [[ $word == --*=* ]]; then
    before=${word%%=*}
    compset -P '*='
  fi
  case $before in
  -m | --method)
    names=(${(f)"$(delassus help methods 2>/dev/null | cut -d' ' -f1)"} gauss-seidel)
    compadd -a names
    return ;;
  -a | --accel) compadd none aitken anderson momentum; return ;;
  esac
  if [[ $word == -* && $word != *=* ]]; then
    names=(${(uf)"$(delassus $command ${words[3]:#-*} --help 2>/dev/null | grep -o -e '--[A-Za-z][A-Za-z-]*')"})
    compadd -a names
    return
  fi
  case $command in
  scene | solve | info | chart | map | profile | report | study)
    names=(${(f)"$(delassus help scenes 2>/dev/null | cut -d' ' -f1)"})
    compadd -a names ;;
  help)
    names=(${(f)"$(delassus help commands 2>/dev/null)"} methods scenes)
    compadd -a names
    return ;;
  esac
  _files
}
_delassus "$@"
