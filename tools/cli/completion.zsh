#compdef muster muster-world muster-uav muster-worker muster-vehicle muster-scheduler muster-recorder
# Completion for muster and the programs that it starts, by way of bash's (completion.bash), which
# reads all of it from their --help: bash says which words fit, and files are zsh's own.

local file script
for file in /usr/local/share /usr/share ${functions_source[_muster]:h:h:h}; do
  [[ -r $file/bash-completion/completions/muster ]] && script=$file/bash-completion/completions/muster
done
local -a fitting
fitting=(${(f)"$(bash -c '
  source "$1" && shift
  COMP_CWORD=$(($1 - 1)) && shift
  COMP_WORDS=("$@")
  _muster && printf "%s\n" "${COMPREPLY[@]}"
' bash "$script" $CURRENT "${(@Q)words}" 2>/dev/null)"})
if (( $#fitting )); then
  compadd -a fitting
else
  _files
fi
