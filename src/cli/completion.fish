# completion.fish: fish completion of delassus: commands, options (from --help), methods, scenes, files.
function __delassus_options
    set -l words (commandline -opc)
    delassus $words[2] (string match -v -- "-*" $words[3]) --help 2>/dev/null | string match -rag -- '(--[A-Za-z][A-Za-z-]*)' | sort -u
end
complete -c delassus -n __fish_use_subcommand -f -a '(delassus help commands 2>/dev/null)'
complete -c delassus -n __fish_use_subcommand -f -a 'help --help --version'
complete -c delassus -n 'not __fish_use_subcommand' -s m -l method -x -a "(delassus help methods 2>/dev/null | cut -d' ' -f1) gauss-seidel"
complete -c delassus -n 'not __fish_use_subcommand' -s a -l accel -x -a 'none aitken anderson momentum'
complete -c delassus -n '__fish_seen_subcommand_from scene solve info chart map profile report study' -a "(delassus help scenes 2>/dev/null | cut -d' ' -f1)"
complete -c delassus -n '__fish_seen_subcommand_from help' -f -a '(delassus help commands 2>/dev/null) methods scenes'
complete -c delassus -n 'not __fish_use_subcommand; and string match -q -- "-*" (commandline -ct)' -f -a '(__delassus_options)'
