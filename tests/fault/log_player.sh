#!/usr/bin/env bash
# A run is recorded; what sensors and arm sent in it, played by lcm-logplayer into a freshly started
# estimator and fusion process, gives the same objects. Of both recordings, whose live processes
# consumed what they could, the offline rerun gives what they gave, message by message.
. "$(dirname "${BASH_SOURCE[0]}")/live_test.sh"

write_config "$out/state"
start_logger "$out/run.lcm"
start_arm
start_camera
start_estimator
start_fusion
"$bin/vantage-progress" --config "$config" --timeout 110 --until-finished >"$out/progress.txt" 2>&1 ||
  give_up "the recorded run did not end"
stop_stack

# count CHANNEL LOG: its messages.
count() { "$bin/vantage-log" info "$2" | awk -v channel="$1" '$1 == channel { print $3 }'; }

# play: into fresh processes, recording all. ARM_STATUS too: fusion learns of it when a view is
# reached. No arm listens to them: the camera goes the recorded way.
play() {
  rm -rf "$out/state-played" "$out/played.lcm"
  write_config "$out/state-played"
  start_logger "$out/played.lcm"
  start_estimator
  start_fusion
  sleep 2
  lcm-logplayer --lcm-url="$LCM_DEFAULT_URL" --regexp='CAMERA_.*|ARM_STATUS' "$out/run.lcm" \
    >"$out/log/player.log" 2>&1 || give_up "lcm-logplayer failed"
  sleep 3
  stop_stack
  local channel
  for channel in CAMERA_XTION CAMERA_XTION_INFO CAMERA_XTION_TO_WORLD ARM_STATUS; do
    [ "$(count $channel "$out/run.lcm")" = "$(count $channel "$out/played.lcm")" ] && continue
    echo "$channel: $(count $channel "$out/run.lcm") messages, $(count $channel "$out/played.lcm") of the played ones recorded"
    return 1
  done
}
# A recording without all that was played, UDP being what it is, could prove nothing.
play || play || play || give_up "three times played messages did not reach the recorder"

for run in run played; do
  "$bin/vantage-report" "$out/$run.lcm" --config "$config" --output "$out/report-$run" \
    --max-rotation-deg 2 --max-position-mm 3 --check || give_up "$run: an object is wrong"
done
"$bin/compare_objects" "$out/run.lcm" "$out/played.lcm" "$config" || give_up "the objects differ"

# rerun LOG ARGS...: as received; it has nothing to warn of and gives what was recorded.
rerun() {
  local log=$1
  shift
  "$bin/vantage-replay" "$out/$log.lcm" --config "$config" --as-received --compare "$@" >"$out/$log.txt" 2>&1
  local code=$?
  cat "$out/$log.txt"
  [ $code -eq 0 ] || give_up "$log: the rerun is not as live"
  ! grep -q '^warning: ' "$out/$log.txt" || give_up "$log: the recording lacks something"
}
rerun run
rerun played --output "$out/once.lcm" --threads 1
rerun played --output "$out/again.lcm" --threads 2
cmp "$out/once.lcm" "$out/again.lcm" || give_up "one thread and two give different bytes"

# The comparison can fail.
"$bin/vantage-replay" "$out/played.lcm" --config "$config" --set fusion.sigma_deg=5 --as-received --compare \
  >"$out/other.txt" 2>&1 && give_up "a rerun with another kernel width compares as equal"
exit 0
