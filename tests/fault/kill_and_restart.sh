#!/usr/bin/env bash
# Estimator, driver and fusion are killed in turn in mid-run and started again: the run still ends
# with every object right.
. "$(dirname "${BASH_SOURCE[0]}")/live_test.sh"

write_config "$out/state"
start_logger "$out/run.lcm"
start_arm
start_camera
start_estimator
start_fusion
"$bin/vantage-progress" --config "$config" --timeout 200 --until-finished >"$out/progress.txt" 2>&1 &
progress=$!

wait_for 60 '^view 2' "$out/progress.txt"
echo "view 2 seen: killing the estimator"
kill_process ppf
sleep 1
start_estimator
wait_for 60 '^view 3' "$out/progress.txt"
echo "view 3 seen: killing the driver"
kill_process openni2
sleep 1
start_camera
wait_for 60 '^view 4' "$out/progress.txt"
echo "view 4 seen: killing the fusion process"
kill_process fusion
sleep 1
start_fusion
wait $progress || give_up "the run did not end: vantage-progress exited with $?"
for name in sim-arm openni2 ppf fusion; do is_running $name || give_up "$name has ended by itself"; done
grep -q 'view 1:' "$out/progress.txt" || give_up "no first view"
stop_stack
"$bin/vantage-report" "$out/run.lcm" --config "$config" --output "$out/report" \
  --max-rotation-deg 2 --max-position-mm 3 --check || give_up "the report says that an object is wrong"
