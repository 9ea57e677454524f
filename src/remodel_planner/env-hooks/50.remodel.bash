# Completes the subcommands of `remodel`; what follows them are files.
_remodel() {
  [ "$COMP_CWORD" -eq 1 ] && mapfile -t COMPREPLY < <(compgen -W "backup charts check draw expectations explain export import \
    layout plan product rehearse replay restore run sequence tasks" -- "${COMP_WORDS[1]}")
}
complete -o default -F _remodel remodel
