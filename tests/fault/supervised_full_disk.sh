#!/usr/bin/env bash
# Run by supervised_run.sh in a mount namespace of its own: the disk of the logs is full, in mid-run and at
# the start.
set -- "$build"
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/fault/live_test.sh"
. "$root/tests/fault/supervised.sh"
mkdir -p "$out/disk"
mount -t tmpfs -o size=300k tmpfs "$out/disk" || exit 0
write_little talker 'while :; do seq 1 2000; sleep 0.1; done'
sed -i "s|^log_folder.*|log_folder = \"$out/disk/log\"|" "$config"
start_up "$config"
wait_for 20 '^all 1 run' "$out/up.txt"
for i in $(seq 100); do [ "$(df --output=avail "$out/disk" | tail -n 1)" -eq 0 ] && break; sleep 0.1; done
[ "$(df --output=avail "$out/disk" | tail -n 1)" -eq 0 ] || give_up "the disk did not fill: nothing is tested"
sleep 2
expect_code 0 "$bin/vantage-up" status "$config" "${folder[@]}"
grep -q 'has ended' "$out/up.txt" && show_and_give_up "a full disk ended a process" "$out/up.txt"
kill "$up"
expect_end 0
expect_gone '^sh -c while'
echo "ok: the disk of the logs fills up"
rm -f "$out"/disk/log/*.log*
head -c 1000000 /dev/zero >"$out/disk/filler" 2>/dev/null
expect_refused "log folder .* can't be written: No space left on device" "$bin/vantage-up" "$config" "${folder[@]}"
umount "$out/disk"
