#!/bin/sh
# An operator at the blocked doorway: nothing but live properties. SERVICE is the name of the desk.
set -eu
desk=${SERVICE:-table}

say() {
    rtset "$desk.command" "$1"
    rtget "$desk.said"
}
question() {
    rtget "$desk.questions" | tr -d '()' | tr ' ' '\n' | grep '^q' | head -n 1
}
answer() {
    rtset "$desk.questions.$(question)" "$1"
    rtget "$desk.said"
}

say 'designate object at (3 3) (3 4) A'
say 'designate object at (6 4) B1'
say 'designate object at (6 3) B2'
say 'designate region at (5 1) (5 6) (4 1) (4 6) aside'
say 'take A to (9 3)'
answer aside
rtget --raw "$desk.questions.$(question).details" | head -n 2
answer b
until rtget "$desk.state" | grep -q idle; do sleep 0.1; done
rtget "$desk.said"
