function rtcwd
    if string match -q -- '-*' $argv[1]
        command rtcwd $argv
        return
    end
    set -l line (SHELL=fish command rtcwd $argv); or return
    eval $line
end

function __rtkit_complete
    set -l token (commandline -ct)
    set -l answer (command rtkit complete fish (commandline -opc) "$token" 2>/dev/null </dev/null)
    switch "$answer[1]"
        case files
            __fish_complete_path "$token"
        case 'files /'
            __fish_complete_directories "$token"
        case 'files *'
            set -l endings (string split ' ' -- $answer[1])[2..]
            set -l fit (string join '|' -- / (string escape --style=regex -- $endings))
            __fish_complete_path "$token" | string match -er -- "^[^\t]*($fit)(\t.*)?\$"
        case '*'
            string join \n -- $answer[2..]
    end
end

for name in @COMMANDS@
    complete -c $name -f -a '(__rtkit_complete)'
end
