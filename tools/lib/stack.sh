# Starts, kills and stops the processes of one set-up. Sourced; needs $root (the project), $bin (its
# programs), $out (where logs go), $config (the TOML file) and LCM_DEFAULT_URL.

declare -A stack_pid=()

# start_process NAME COMMAND...: in the background, its output appended to $out/log/NAME.log.
start_process() {
  local name=$1
  shift
  mkdir -p "$out/log"
  "$@" >>"$out/log/$name.log" 2>&1 &
  stack_pid[$name]=$!
}

start_arm() { start_process sim-arm "$bin/vantage-sim-arm" --config "$config"; }
start_camera() {
  start_process openni2 env LD_LIBRARY_PATH="$bin/../openni2${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}" \
    VANTAGE_SIM_CONFIG="$config" "$bin/vantage-openni2" --config "$config"
}
start_estimator() { start_process ppf "$bin/vantage-ppf" --config "$config"; }
start_fusion() { start_process fusion "$bin/vantage-fusion" --config "$config" "$@"; }

# start_logger FILE: records everything.
start_logger() {
  start_process recorder "$bin/vantage-log" record --config "$config" --output "$1" --force
}

# is_running NAME
is_running() { [ -n "${stack_pid[$1]:-}" ] && kill -0 "${stack_pid[$1]}" 2>/dev/null; }

# stop_process NAME: asks it to end, waits 5 s, then kills it.
stop_process() {
  local pid=${stack_pid[$1]:-} i
  [ -n "$pid" ] || return 0
  kill -TERM "$pid" 2>/dev/null
  for i in $(seq 50); do
    kill -0 "$pid" 2>/dev/null || break
    sleep 0.1
  done
  kill -KILL "$pid" 2>/dev/null
  wait "$pid" 2>/dev/null
  unset "stack_pid[$1]"
}

# kill_process NAME: as a crash would.
kill_process() {
  kill -KILL "${stack_pid[$1]}"
  wait "${stack_pid[$1]}" 2>/dev/null
  unset "stack_pid[$1]"
}

# stop_stack: those who ask first, the logger last.
stop_stack() {
  local name
  for name in fusion ppf openni2 sim-arm; do stop_process "$name"; done
  for name in "${!stack_pid[@]}"; do stop_process "$name"; done
}
