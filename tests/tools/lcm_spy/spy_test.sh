#!/usr/bin/env bash
# lcm-spy as tools/spy starts it, on a screen of its own (Xvfb) in a network of its own: spy_messages'
# log is played, and SpyTest, an agent inside lcm-spy's Java, opens every window and looks at it.
#   spy_test.sh BUILD_FOLDER   with VANTAGE_SPY_SCREENSHOTS=FOLDER the screenshots stay there
set -u -o pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)
build=$(cd "$1" && pwd)
. "$root/tools/lib/network.sh"

for command in Xvfb java lcm-logplayer; do
  command -v "$command" >/dev/null || {
    echo "skipped: there is no $command; tools/test installs it"
    exit 77
  }
done
enter_private_network "$0" "$@"
[ -n "${VANTAGE_PRIVATE_NETWORK:-}" ] || exit 77

out=$(mktemp -d)
pids=()
clean_up() {
  for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null; done
  wait 2>/dev/null
  rm -rf "$out"
}
trap clean_up EXIT

give_up() {
  echo "FAILED: $*"
  tail -n 40 "$out"/*.log
  exit 1
}

# refused TEXT ARGUMENTS...: tools/spy ends with 2 and one sentence with the text.
refused() {
  local text=$1
  shift
  "$@" >"$out/refused.log" 2>&1
  [ $? -eq 2 ] || give_up "not refused with exit code 2: $*"
  grep -qF -- "$text" "$out/refused.log" || give_up "\"$text\" is not in what was said to: $*"
}

jar=$build/share/java/lcmtypes_vantage.jar
refused "unknown option --url" "$root/tools/spy" --url x
refused "--lcm-url needs a value" "$root/tools/spy" --lcm-url
refused "none that lcm-spy knows" "$root/tools/spy" --lcm-url http://here
refused "cannot be read" env DISPLAY=:0 "$root/tools/spy" --jar "$out/absent.jar"
refused "DISPLAY is not set" env -u DISPLAY "$root/tools/spy" --jar "$jar"
refused "no multicast route" env DISPLAY=:0 "$root/tools/spy" --jar "$jar" --lcm-url udpm://10.9.8.7:7667

# -displayfd: the server takes a free number and says which.
Xvfb -displayfd 3 -screen 0 1400x1000x24 -nolisten tcp 3>"$out/display" >"$out/xvfb.log" 2>&1 &
pids+=($!)
for _ in $(seq 100); do
  [ -s "$out/display" ] && break
  sleep 0.1
done
[ -s "$out/display" ] || give_up "Xvfb did not start"
export DISPLAY=:$(cat "$out/display")
export LCM_DEFAULT_URL="udpm://239.255.76.67:7667?ttl=0"

"$build/bin/spy_messages" "$out/messages.lcm" "$out/facts.properties" "$(date +%s)000000" ||
  give_up "spy_messages failed"
# Ends by itself when the test has seen everything; CLASSPATH is what users have with jars of others.
CLASSPATH=$jar:$out JAVA_TOOL_OPTIONS="-javaagent:$build/share/test/spy_test.jar=$out/facts.properties" \
  "$root/tools/spy" --jar "$jar" >"$out/spy.log" 2>&1 &
spy=$!
pids+=("$spy")
while lcm-logplayer "$out/messages.lcm" >>"$out/player.log" 2>&1; do :; done &
pids+=($!)
wait "$spy" || give_up "lcm-spy's windows are not as they must be"
grep -q "Found 6 plugins" "$out/spy.log" || give_up "other than 6 plugins"
grep -E "spy test|decoded|shown|survived" "$out/spy.log"
