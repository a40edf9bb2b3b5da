#!/bin/sh
# Every study below a folder is handed in, evaluated by a service, fetched, and set beside the others.
#
#     EXOGAUGE_URL=https://exo.example EXOGAUGE_TOKEN=… sh nightly.sh recordings found
#
# To be run as often as one likes, by cron say: what is done stays done, and what was broken off goes on.
# Ends with 0; with 1 where a study did not succeed; with 3 where the service does not answer, so try later;
# with 4 where the token does not do.
set -u
recordings=$1 found=$2 worst=0 jobs=""
mkdir -p "$found"

ended() { # ended CODE WHAT: go on to the next study, unless no other would fare better
    [ "$1" -eq 3 ] || [ "$1" -eq 4 ] && exit "$1"
    echo "$2: ended with $1" >&2
    worst=1
}

for study in "$recordings"/*/; do # all of them, so that all wait in the queue
    name=$(basename "$study")
    exogauge run "$study" --server "$EXOGAUGE_URL" --no-wait > "$found/$name.job" || ended $? "$name"
done

for file in "$found"/*.job; do
    [ -s "$file" ] || continue
    name=$(basename "$file" .job) job=$(cat "$file")
    if exogauge wait "$job" --timeout 21600 && exogauge results "$job" --out "$found/$name"; then
        jobs="$jobs $job"
    else
        ended $? "$name"
    fi
done

# shellcheck disable=SC2086
[ -z "$jobs" ] || exogauge compare $jobs --table stiffness > "$found/stiffness.csv" || ended $? comparison
exit "$worst"
