# shellcheck shell=bash
# Completion for muster and the programs that it starts. All of it is read from their --help, so it
# is always that of the program at hand.

# _muster_commands HELP
_muster_commands() {
  sed -n '/^Commands:/,/^$/s/^  \([a-z-]*\) .*/\1/p' <<<"$1"
}

# _muster_options HELP
_muster_options() {
  sed -n 's/^ *\(-[A-Za-z], \)\?\(--[a-z][a-z-]*\).*/\2/p' <<<"$1"
}

# _muster_values PROGRAM HELP OPTION: the words that the option takes, if it takes words.
_muster_values() {
  local text
  # The option and what is said of it, in one line.
  text=$(awk -v option="$3" '
    /^ *-/ { on = 0; for (i = 1; i <= 2; ++i) if ($i == option) on = 1 }
    /^$/ { on = 0 }
    on { sub(/^ +/, ""); printf "%s ", $0 }' <<<"$2")
  case $text in
    *'How to decide: '*) "${1%/*}"/muster policies 2>/dev/null | awk '/^  / { print $1 }' ;;
    *'--preset '*) "${1%/*}"/muster scenario --list 2>/dev/null | awk 'NR > 1 { print $1 }' ;;
    # Of bursts:N what comes before the number.
    *) sed -n 's/^.*--[a-z-]* \([a-z]*|[a-z:N|]*\) .*/\1/p' <<<"$text" | tr '|' ' ' | tr -d N ;;
  esac
}

_muster() {
  local program=${COMP_WORDS[0]} word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}
  program=$(type -P "${program/#\~/$HOME}") || return
  # bash takes --policy=mpq for three words.
  [[ $before == '=' ]] && before=${COMP_WORDS[COMP_CWORD - 2]}
  [[ $word == '=' ]] && word=
  local help commands at=1 path=("$program")
  while true; do
    help=$("${path[@]}" --help 2>/dev/null)
    commands=$(_muster_commands "$help")
    ((at < COMP_CWORD)) && grep -qx -e "${COMP_WORDS[at]}" <<<"$commands" || break
    path+=("${COMP_WORDS[at]}")
    ((++at))
  done
  local words=''
  if [[ $word == -* ]]; then
    words=$(_muster_options "$help")
  elif [[ $before == -* ]]; then
    words=$(_muster_values "$program" "$help" "$before")
  elif ((at == COMP_CWORD)); then
    words=$commands
  fi
  # Where there are no words, files: complete -o default.
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
}

complete -o default -F _muster \
  muster muster-world muster-uav muster-worker muster-vehicle muster-scheduler muster-recorder
