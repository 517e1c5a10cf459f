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

# restart_after VIEW NAME START: once the view is seen, kills the process and starts it again. The
# run must not have ended by then, or nothing would be tested.
restart_after() {
  wait_for 60 "^view $1" "$out/progress.txt"
  echo "view $1 seen: killing $2"
  kill_process "$2"
  sleep 1
  "$3"
  kill -0 $progress 2>/dev/null || give_up "the run had ended before $2 was started again"
  wait_for 60 "^view $(($1 + 1))" "$out/progress.txt"
}

restart_after 1 fusion start_fusion
restart_after 2 ppf start_estimator
restart_after 3 openni2 start_camera
restart_after 4 fusion start_fusion
wait $progress || give_up "the run did not end: vantage-progress exited with $?"
for name in sim-arm openni2 ppf fusion; do is_running $name || give_up "$name has ended by itself"; done
stop_stack
"$bin/vantage-report" "$out/run.lcm" --config "$config" --output "$out/report" \
  --max-rotation-deg 2 --max-position-mm 3 --check || give_up "the report says that an object is wrong"
