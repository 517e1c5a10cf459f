#!/usr/bin/env bash
# A run is recorded with lcm-logger; its sensor channels, played by lcm-logplayer into a freshly
# started estimator and fusion process, give the same objects.
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

write_config "$out/state-played"
start_logger "$out/played.lcm"
start_estimator
start_fusion
sleep 2
lcm-logplayer --lcm-url="$LCM_DEFAULT_URL" --regexp='CAMERA_.*' "$out/run.lcm" >"$out/log/player.log" 2>&1 ||
  give_up "lcm-logplayer failed"
sleep 3
stop_stack

for run in run played; do
  "$bin/vantage-report" "$out/$run.lcm" --config "$config" --output "$out/report-$run" \
    --max-rotation-deg 2 --max-position-mm 3 --check || give_up "$run: an object is wrong"
done
"$bin/compare_objects" "$out/run.lcm" "$out/played.lcm" "$config" || give_up "the objects differ"
