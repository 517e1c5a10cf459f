#!/usr/bin/env bash
# vantage-up with the simulated set-up and with little ones: what dies comes back, what fails for good is
# told, all end in order, whoever is killed; and what a user may get wrong.
. "$(dirname "${BASH_SOURCE[0]}")/live_test.sh"
. "$root/tests/fault/supervised.sh"
command -v supervisord >/dev/null || { echo "supervisor is not installed"; exit 77; }

# ---- The simulated set-up, recorded ----
write_config "$out/state"
cat >>"$config" <<TEXT
[up]
record = "$out/records"
log_folder = "$out/log"
start_s = 2
TEXT
start_up "$config"
wait_for 30 '^all 5 run' "$out/up.txt"
"$bin/vantage-progress" --config "$config" --timeout 200 --until-finished >"$out/progress.txt" 2>&1 &
progress=$!
for name in sim-arm openni2 ppf fusion; do wait_for 30 "^process $name is up" "$out/progress.txt"; done
expect_code 0 "$bin/vantage-up" status "$config" "${folder[@]}"
expect_refused 'another vantage-up is at work' "$bin/vantage-up" "$config" "${folder[@]}"
kill -KILL "$(pid_of ppf)"
wait_for 20 'ppf has ended \(terminated by SIGKILL\)' "$out/up.txt"
[ "$(grep -c 'ppf runs' "$out/up.txt")" = 1 ] || give_up "ppf ran again before it had ended"
wait_for 20 '^process ppf was started again' "$out/progress.txt"
wait_for 60 '^view 2' "$out/progress.txt"
kill "$progress"
kill -INT "$up"
expect_end 0
stopped=$(sed -n 's/.*stopped: \([a-z0-9-]*\).*/\1/p' "$out/log/supervisord.log" | tr '\n' ' ')
[ "$stopped" = 'fusion ppf openni2 sim-arm recorder ' ] || give_up "the order of stopping was $stopped"
expect_gone 'vantage-[a-z0-9]* --config'
record=$(ls "$out"/records/*.lcm)
"$bin/vantage-log" info "$record" >"$out/info.txt" || give_up "the recording is no whole log"
for channel in OBJECTS DETECTIONS_PPF CAMERA_XTION ARM_STATUS; do
  grep -q "^$channel " "$out/info.txt" || give_up "the recording lacks $channel"
done
echo "ok: the simulated set-up"

# ---- Little set-ups: processes of the user's own ----
write_little sleeper 'exec sleep 1000' other 'exec sleep 1001'
start_up "$config"
wait_for 20 '^all 2 run' "$out/up.txt"
kill -KILL "$(supervisorctl -c "$run/supervisord.conf" pid)"
expect_end 1
grep -q 'supervisord has ended by itself' "$out/up.txt" || give_up "nothing is said of a dead supervisor"
expect_gone '^sleep 100'
[ -S "$run/supervisor.sock" ] || give_up "the killed supervisor left no socket: nothing is tested below"
expect_code 0 "$bin/vantage-up" "$config" --daemon "${folder[@]}"
expect_refused 'is up already' "$bin/vantage-up" "$config" --daemon "${folder[@]}"
expect_code 0 "$bin/vantage-up" stop "$config" other "${folder[@]}"
expect_gone '^sleep 1001'
expect_code 1 "$bin/vantage-up" status "$config" "${folder[@]}"
expect_code 0 "$bin/vantage-up" restart "$config" other "${folder[@]}"
expect_code 1 "$bin/vantage-up" stop "$config" nobody "${folder[@]}"
write_little sleeper 'exec sleep 1000' third 'exec sleep 1002'
expect_code 0 "$bin/vantage-up" restart "$config" "${folder[@]}"
expect_gone '^sleep 1001'
[ -n "$(ours '^sleep 1002')" ] || give_up "restart did not start what the configuration has gained"
[ "$(stat -c %a "$run" "$run/supervisor.sock" | tr '\n' ' ')" = '700 700 ' ] || give_up "others may reach the socket"
expect_code 0 "$bin/vantage-up" stop "$config" "${folder[@]}"
expect_gone '^sleep 100'
expect_refused 'the set-up is not up' "$bin/vantage-up" stop "$config" "${folder[@]}"
echo "ok: a dead supervisor, its socket, and the subcommands"

start_up "$config"
wait_for 20 '^all 2 run' "$out/up.txt"
kill -KILL "$up"
wait "$up" 2>/dev/null
expect_gone '^sleep 100'
echo "ok: a killed vantage-up takes all with it"

# One that takes no hint is killed; what it started goes too.
write_little stubborn "trap '' TERM; sleep 1003; sleep 1003"
sed -i 's/^start_s.*/&\nstop_s = 1/' "$config"
start_up "$config"
wait_for 20 '^all 1 run' "$out/up.txt"
kill "$up"
expect_end 0
expect_gone '^sleep 1003'
echo "ok: a stubborn process"

write_little sleeper 'exec sleep 1000' broken 'echo first words; echo there is no lens; exit 3'
start_up "$config"
expect_end 1
grep -q 'vantage-up: broken does not stay up; its last words: there is no lens' "$out/up.txt" ||
  give_up "it is not told what failed"
[ "$(grep -c 'broken has ended' "$out/up.txt")" = 2 ] || give_up "it was not tried twice"
expect_gone '^sleep 100'
expect_code 1 "$bin/vantage-up" "$config" --daemon "${folder[@]}"
grep -q 'there is no lens' "$out/output" || give_up "--daemon does not tell what failed"
expect_gone '^sleep 100'
echo "ok: a process that fails for good: $(grep 'does not stay up' "$out/up.txt")"

# A recorder that ends, as at a full disk, leaves the others alone.
write_little sleeper 'exec sleep 1000'
cat >>"$config" <<TEXT
[[up.process]]
name = "recorder"
command = ["sh", "-c", "sleep 4; echo the disk is full; exit 1"]
TEXT
sed -i "s|^start_s.*|&\nrecord = \"$out/records\"|" "$config"
start_up "$config"
wait_for 20 'recorder has ended .exit status 1.; its last words: the disk is full' "$out/up.txt"
sleep 2
[ -n "$(ours '^sleep 1000')" ] || give_up "the others ended with the recorder"
kill "$up"
expect_end 0
[ "$(grep -c 'recorder starts' "$out/up.txt")" = 1 ] || give_up "the recorder was started again"
echo "ok: a recorder that ends"

# Logs are rotated, and a full disk below them does not end the processes.
write_little talker 'while :; do seq 1 20000; sleep 0.1; done'
sed -i 's/^start_s.*/&\nlog_size_mb = 1\nlog_files = 2/' "$config"
start_up "$config"
wait_for 20 '^all 1 run' "$out/up.txt"
for i in $(seq 200); do [ -e "$out/log/talker.log.2" ] && break; sleep 0.1; done
kill "$up"
expect_end 0
[ "$(ls "$out"/log/talker.log* | wc -l)" -le 3 ] || give_up "more logs are kept than were asked for"
[ "$(du -sk "$out/log" | cut -f 1)" -le 4096 ] || give_up "logs grow beyond their limit"
echo "ok: logs are rotated"
if unshare -m true 2>/dev/null; then
  build="$build" unshare -m bash "$root/tests/fault/supervised_full_disk.sh" || exit 1
fi

# ---- What a user may get wrong ----
write_little sleeper 'exec sleep 1000'
good=$(cat "$config")
expect_refused 'none.toml is not there' "$bin/vantage-up" "$out/none.toml"
expect_refused 'a config file is required' "$bin/vantage-up"
expect_refused 'supervisord is not installed; .*apt-get install supervisor' \
  env PATH=/nowhere "$bin/vantage-up" "$config" "${folder[@]}"
expect_refused 'expected at most [0-9]+; choose a shorter one with --folder' \
  "$bin/vantage-up" "$config" --folder "$out/$(printf 'x%.0s' $(seq 90))"
expect_refused "has ';' or '#' after one" "$bin/vantage-up" "$config" --folder "$out/a #b"
expect_refused "run folder $config/below can't be made" "$bin/vantage-up" "$config" --folder "$config/below"
sed -i "s|^log_folder.*|log_folder = \"$config/below\"|" "$config"
expect_refused "log folder .*/below can't be made" "$bin/vantage-up" "$config" "${folder[@]}"
sed -i 's|^log_folder.*|log_folder = "/proc/vantage"|' "$config"
expect_refused "log folder /proc/vantage can't be made" "$bin/vantage-up" "$config" "${folder[@]}"
printf '%s\n[[up.process]]\nname = "ghost"\ncommand = ["./ghost"]\n' "$good" >"$config"
expect_refused 'the program ./ghost of process ghost is not there' "$bin/vantage-up" "$config" "${folder[@]}"
printf '%s\n[fusion]\nk = 5000\n' "$good" >"$config"
expect_refused 'fusion.k = 5000: expected a number from 2 to 128' "$bin/vantage-up" "$config" "${folder[@]}"
expect_gone '^sleep 100'
