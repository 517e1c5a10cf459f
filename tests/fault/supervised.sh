# What the tests of vantage-up share. Sourced after live_test.sh.
run=$out/run
folder=(--folder "$run")

clean_up_supervised() {
  [ -S "$run/supervisor.sock" ] && "$bin/vantage-up" stop "$config" "${folder[@]}" >/dev/null 2>&1
  [ -n "${up:-}" ] && kill -KILL "$up" 2>/dev/null
  clean_up
}
trap clean_up_supervised EXIT

# start_up CONFIG: vantage-up in the foreground, its output in $out/up.txt.
start_up() {
  : >"$out/up.txt"
  "$bin/vantage-up" "$1" "${folder[@]}" >"$out/up.txt" 2>&1 &
  up=$!
}

# expect_end CODE: of the vantage-up that was started.
expect_end() {
  local code
  wait "$up"
  code=$?
  [ $code -eq "$1" ] || show_and_give_up "vantage-up exited with $code, expected $1" "$out/up.txt"
}

# expect_code CODE COMMAND...
expect_code() {
  local expected=$1 code
  shift
  timeout 60 "$@" >"$out/output" 2>&1
  code=$?
  [ $code -eq "$expected" ] || show_and_give_up "$* exited with $code, expected $expected" "$out/output"
}

# expect_refused PATTERN COMMAND...: exit code 2, one sentence that matches, nothing started.
expect_refused() {
  local pattern=$1
  shift
  expect_code 2 "$@"
  [ "$(wc -l <"$out/output")" = 1 ] || show_and_give_up "$* said more than one sentence" "$out/output"
  grep -qE -- "$pattern" "$out/output" || show_and_give_up "$*: expected \"$pattern\"" "$out/output"
  echo "ok: $(cat "$out/output")"
}

show_and_give_up() {
  cat "$2"
  give_up "$1"
}

# pid_of PROCESS
pid_of() { supervisorctl -c "$run/supervisord.conf" pid "$1"; }

# ours PATTERN: process ids of this network whose command line matches.
ours() {
  local pid
  for pid in $(pgrep -f -- "$1"); do
    [ "$(readlink "/proc/$pid/ns/net")" = "$(readlink /proc/self/ns/net)" ] && echo "$pid"
  done
}

# expect_gone PATTERN: soon no process of ours matches.
expect_gone() {
  local i
  for i in $(seq 100); do
    [ -z "$(ours "$1")" ] && return 0
    sleep 0.1
  done
  give_up "still there: $(ours "$1" | xargs ps -o pid,args -p)"
}

# write_little NAME SHELL_TEXT [NAME SHELL_TEXT]...: a set-up of the user's own processes alone.
write_little() {
  rm -rf "$out/log"
  printf '[up]\nlog_folder = "%s"\nstart_s = 2\nstart_retries = 1\n' "$out/log" >"$config"
  while [ $# -gt 0 ]; do
    printf '[[up.process]]\nname = "%s"\ncommand = ["/bin/sh", "-c", "%s"]\n' "$1" "$2" >>"$config"
    shift 2
  done
}
