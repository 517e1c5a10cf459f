#!/usr/bin/env bash
# vantage-log record beside lcm-logger, killed, on a disk that fills, and twice on the same file.
. "$(dirname "${BASH_SOURCE[0]}")/live_test.sh"

log=("$bin/vantage-log")
cd "$out" || exit 1

# Views to play: noise, so that they don't compress away.
python3 - <<'PYTHON' || give_up "no views"
import os, random, struct, zlib

def chunk(kind, data):
    return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))

os.mkdir('views')
random.seed(1)
width, height = 160, 120
for view in range(20):
    rows = b''.join(b'\0' + random.randbytes(2 * width) for _ in range(height))
    with open(f'views/depth_{view}.png', 'wb') as file:
        file.write(b'\x89PNG\r\n\x1a\n'
                   + chunk(b'IHDR', struct.pack('>IIBBBBB', width, height, 16, 0, 0, 0, 0))
                   + chunk(b'IDAT', zlib.compress(rows)) + chunk(b'IEND', b''))
    with open(f'views/world_T_camera_{view}.txt', 'w') as file:
        file.write(f'1 0 0 {view}\n0 1 0 0\n0 0 1 0\n0 0 0 1\n')
with open('views/Intrinsic.txt', 'w') as file:
    file.write('200 0 80\n0 200 60\n0 0 1\n')
PYTHON
"${log[@]}" import views --camera A --output views.lcm >/dev/null || give_up "no log to play"

# events FILE: every whole event but LOG_HEADER and what the recorders say themselves, as a line.
events() {
  python3 - "$1" <<'PYTHON'
import hashlib, struct, sys

data = open(sys.argv[1], 'rb').read()
at = 0
while at + 28 <= len(data):
    sync, number, utime, channel_size, size = struct.unpack('>IqqII', data[at:at + 28])
    end = at + 28 + channel_size + size
    if sync != 0xeda1da01 or end > len(data):
        break
    channel = data[at + 28:at + 28 + channel_size].decode()
    if channel not in ('LOG_HEADER', 'PROCESS_STATUS', 'LCM_SELF_TEST'):
        print(channel, hashlib.sha256(data[at + 28 + channel_size:end]).hexdigest())
    at = end
sys.exit(0 if at == len(data) else 3)
PYTHON
}

# play: 1,660 events and 0.9 MB in 4 s.
play() { lcm-logplayer --lcm-url="$LCM_DEFAULT_URL" -s 5 -e '^(?!LOG_HEADER).*' views.lcm >log/player.log 2>&1; }

# start_recorder NAME ARGUMENTS...: returns when it records.
start_recorder() {
  local name=$1
  shift
  rm -f "log/$name.log"
  start_process "$name" "${log[@]}" record --min-free-mb 0 "$@"
  wait_for 5 'recording udpm' "log/$name.log"
}

# ended_with NAME CODE PATTERN: within 10 s by itself.
ended_with() {
  local i code
  for i in $(seq 100); do is_running "$1" || break; sleep 0.1; done
  is_running "$1" && give_up "$1 goes on"
  wait "${stack_pid[$1]}"
  code=$?
  unset "stack_pid[$1]"
  [ $code -eq "$2" ] || give_up "$1 ended with $code, expected $2"
  grep -qE "$3" "log/$1.log" || give_up "$1 does not say \"$3\""
}

# whole FILE LOWEST: nothing damaged, at least so many events of those that were played.
whole() {
  local count
  events "$1" >whole.txt || give_up "$1 does not end with a whole event"
  count=$(wc -l <whole.txt)
  [ "$count" -ge "$2" ] || give_up "$1 has $count events, expected $2 at least"
  head -n "$count" played.txt | cmp -s - whole.txt || give_up "$1 has other events than were played"
  echo "ok: $1: $count events"
}

mkdir log
events views.lcm >played.txt
total=$(wc -l <played.txt)

write_config "$out/state"
sed -i -e 's|^folder = .*|folder = "models"|' "$config"
start_process lcm-logger lcm-logger --lcm-url="$LCM_DEFAULT_URL" -q -f theirs.lcm
start_recorder recorder --config "$config" --output ours.lcm
"${log[@]}" record --output ours.lcm 2>refused.txt && give_up "an existing log was written over"
grep -q 'ours.lcm exists already' refused.txt || give_up "$(cat refused.txt)"
"${log[@]}" record --min-free-mb 0 --force --output ours.lcm 2>refused.txt && give_up "two wrote to one file"
grep -q 'another recording writes to ours.lcm' refused.txt || give_up "$(cat refused.txt)"
start_recorder second --folder logs --channels 'CAMERA_A.*' --exclude '.*_TO_WORLD' --split-mb 0.2
play || give_up "lcm-logplayer failed"
sleep 0.5
stop_process second
stop_process recorder
stop_process lcm-logger
whole ours.lcm "$total"
events theirs.lcm >theirs.txt
cmp -s theirs.txt whole.txt || give_up "lcm-logger recorded other events"
grep -q 'nothing lost' log/recorder.log || give_up "losses were told where there were none"
grep -aq "folder = '$out/models'" ours.lcm || give_up "the configuration in LOG_HEADER has no absolute path"
[ "$(ls logs/*.lcm | wc -l)" -ge 3 ] || give_up "the recording was not split"
for part in logs/*.lcm; do
  head -c 60 "$part" | grep -aq LOG_HEADER || give_up "$part has no LOG_HEADER first"
  events "$part" >part.txt || give_up "$part is cut off"
  cat part.txt
done | LC_ALL=C sort >parts.txt
grep -v _TO_WORLD whole.txt | LC_ALL=C sort | cmp -s - parts.txt || give_up "the parts have not what was asked for"
echo "ok: $(ls logs | wc -l) parts: $(wc -l <parts.txt) events"

start_recorder killed --output killed.lcm
play || give_up "lcm-logplayer failed"
sleep 1
kill_process killed
whole killed.lcm "$total"

start_recorder limited --output other.lcm
stop_process limited
rm other.lcm
(ulimit -f 100; exec "${log[@]}" record --min-free-mb 0 --output limited.lcm) >log/limited.log 2>&1 &
stack_pid[limited]=$!
wait_for 5 'recording udpm' log/limited.log
play
ended_with limited 1 'recording ended: recording limited.lcm can.t be written: File too large; what was written before is kept'
whole limited.lcm 50

# A disk of 300 kB, where the system lets us have one.
if [ -z "${VANTAGE_NO_MOUNT:-}" ] && unshare -m true 2>/dev/null; then
  mkdir disk
  unshare -m --propagation private sh -c '
    mount -t tmpfs -o size=300k none disk || exit 9
    "$0" record --min-free-mb 1 --output disk/none.lcm 2>none.txt
    echo $? >none.code
    ls disk >>none.txt
    "$0" record --min-free-mb 0 --output disk/full.lcm >log/full.log 2>&1
    echo $? >full.code
    cp disk/full.lcm . ; rm disk/full.lcm
    while [ ! -e played ]; do sleep 0.1; done
    "$0" record --min-free-mb 0.1 --output disk/spare.lcm >log/spare.log 2>&1
    echo $? >spare.code
    cp disk/spare.lcm .' "${log[0]}" &
  stack_pid[disk]=$!
  wait_for 5 'recording udpm' log/full.log
  play
  touch played
  wait_for 5 'recording udpm' log/spare.log
  play
  wait "${stack_pid[disk]}" || give_up "no small disk"
  unset 'stack_pid[disk]'
  [ "$(cat none.code)" = 2 ] && grep -q 'expected 1 MB (--min-free-mb)' none.txt || give_up "a full disk was begun on: $(cat none.txt)"
  [ "$(wc -l <none.txt)" = 1 ] || give_up "something was left on a full disk: $(cat none.txt)"
  [ "$(cat full.code)" = 1 ] && grep -q 'No space left on device; what was written' log/full.log || give_up "full disk: $(cat log/full.log)"
  whole full.lcm 100
  [ "$(cat spare.code)" = 1 ] && grep -q 'has 0.0[0-9]* MB left, expected 0.1 MB' log/spare.log || give_up "nearly full disk: $(cat log/spare.log)"
  whole spare.lcm 50
fi
exit 0
