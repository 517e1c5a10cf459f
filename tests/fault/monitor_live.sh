#!/usr/bin/env bash
# vantage-top --check on a set-up that runs: ok; then a process is killed, and it is named.
# vantage-doctor on the same network: what it prints mends what is broken.
. "$(dirname "${BASH_SOURCE[0]}")/live_test.sh"

# A machine that is busy with other things may miss frames and be late.
limits="--max-missed 1 --max-silence 4 --max-camera-latency 10"
top() { "$bin/vantage-top" --config "$config" $limits "$@" >"$out/top.txt" 2>&1; }

# expect_line PATTERN FILE
expect_line() { grep -qE "$1" "$2" || { cat "$2"; give_up "no line of $2 matched \"$1\""; }; }

doctor() { "$bin/vantage-doctor" "$@" >"$out/doctor.txt" 2>&1; }
# doctor_says LEVEL SUBJECT: a line of that level about it.
doctor_says() { expect_line "^$1 +$2 " "$out/doctor.txt"; }

# mend SUBJECT: runs the command that the doctor prints below its line about it.
mend() {
  local command
  command=$(grep -A1 -E "^(wrong|warning) +$1 " "$out/doctor.txt" | sed -n 's/^ *\$ //p')
  [ -n "$command" ] || { cat "$out/doctor.txt"; give_up "the doctor knows nothing that mends $1"; }
  echo "mending $1: $command"
  sh -c "$command" || give_up "the command failed: $command"
}

write_config "$out/state"

# Without a route nothing runs; the printed command mends it.
ip route del 224.0.0.0/4 dev lo
top --check --seconds 1
[ $? -eq 2 ] || give_up "vantage-top does not exit with 2 without a route"
expect_line "no multicast route" "$out/top.txt"
doctor && give_up "the doctor finds nothing wrong without a route"
doctor_says wrong "multicast route"
mend "multicast route"
doctor
doctor_says ok "multicast route"
ip link set lo down
doctor && give_up "the doctor finds nothing wrong while lo is down"
mend "multicast route"
doctor
doctor_says ok "multicast route"
doctor_says ok "LCM round trip"

start_arm
start_camera
start_estimator
start_fusion
for i in $(seq 30); do
  top --check --seconds 3 && break
done
expect_line "^ok$" "$out/top.txt"
echo "all is well"

top --once --seconds 2 || give_up "no snapshot"
for part in "^fusion " "^ppf " "^openni2 " "^sim-arm " "^XTION +streaming" "^CAMERA_XTION +images_t"; do
  expect_line "$part" "$out/top.txt"
done
top --json --seconds 2 || give_up "no JSON"
python3 -c 'import json, sys; sys.exit(not json.load(open(sys.argv[1]))["ok"])' "$out/top.txt" ||
  give_up "the JSON says that something is wrong"

# One that hangs holds its name; the doctor and top name it.
kill -STOP "${stack_pid[ppf]}"
sleep 1
doctor --config "$config" && give_up "the doctor overlooks a process that hangs"
doctor_says wrong "process ppf"
top --check --seconds 6
[ $? -eq 1 ] || give_up "vantage-top overlooks a process that hangs"
expect_line "^process ppf" "$out/top.txt"
kill -CONT "${stack_pid[ppf]}"

# Killed in mid-watch.
"$bin/vantage-top" --config "$config" $limits --check --seconds 12 >"$out/top.txt" 2>&1 &
watch=$!
sleep 4
kill_process ppf
wait $watch
[ $? -eq 1 ] || give_up "vantage-top overlooks a process that was killed"
expect_line "^process ppf: silent for" "$out/top.txt"
# And before the watch: only the configuration knows of it.
top --check --seconds 4
[ $? -eq 1 ] || give_up "vantage-top overlooks a process that is not there"
expect_line "^process ppf was never heard" "$out/top.txt"
echo "the killed process was named"
