rtcwd() {
    case "${1-}" in
        -*) command rtcwd "$@"; return ;;
    esac
    local line
    line=$(SHELL=zsh command rtcwd "$@") || return
    eval "$line"
}

_rtkit_complete() {
    local -a answer open shut open_told shut_told
    local line word name about
    answer=("${(@f)$(command rtkit complete zsh "${(@Q)words[1,CURRENT-1]}" "${(Q)PREFIX}" \
        2>/dev/null </dev/null)}")
    case "$answer[1]" in
        files) _files; return ;;
        'files /') _files -/; return ;;
        files*) _files -g "*(${${answer[1]#files }// /|})(-.)"; return ;;
    esac
    for line in "${(@)answer[2,-1]}"; do
        word=${line%%$'\t'*}
        about=${line#*$'\t'}
        name=${${word%/}##*/}${word##*[^/]}
        about="$name${about:+  -- $about}"
        case "$word" in
            *[/:=.]) open+=("$word"); open_told+=("$about") ;;
            *) shut+=("$word"); shut_told+=("$about") ;;
        esac
    done
    (( $#open + $#shut )) || return 1
    (( $#open )) && compadd -S '' -l -d open_told -a open
    (( $#shut )) && compadd -l -d shut_told -a shut
    return 0
}

if [[ -o interactive ]]; then
    (( $+functions[compdef] )) || { autoload -Uz compinit && compinit -i; }
    compdef _rtkit_complete @COMMANDS@
fi
