# What the live tests share. Sourced with the script's arguments; the first is the build folder.
set -u -o pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$(cd "$1" && pwd)
bin=$build/bin
. "$root/tools/lib/network.sh"
. "$root/tools/lib/stack.sh"

enter_private_network "$0" "$@"
[ -n "${VANTAGE_PRIVATE_NETWORK:-}" ] || exit 77
export LCM_DEFAULT_URL="udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304"
out=$(mktemp -d)
config=$out/set-up.toml
clean_up() {
  stop_stack
  [ "${keep_output:-no}" = yes ] || rm -rf "$out"
}
trap clean_up EXIT

# write_config STATE_FILE: the demo's set-up with its own saved state.
write_config() {
  # Six views: room for what the tests do in mid-run.
  sed -e "s|^min_views = .*|min_views = 6|" -e "s|^folder = .*|folder = \"$root/models\"|" \
    -e "s|^\[fusion\]|[fusion]\nstate_file = \"$1\"|" "$root/config/demo.toml" >"$config"
}

# give_up SENTENCE: shows what the processes said.
give_up() {
  echo "FAILED: $*"
  tail -n 15 "$out"/log/*.log "$out"/progress.txt 2>/dev/null
  exit 1
}

# wait_for SECONDS PATTERN FILE: until a line of the file matches.
wait_for() {
  local i
  for i in $(seq $(($1 * 10))); do
    grep -qE "$2" "$3" 2>/dev/null && return 0
    sleep 0.1
  done
  give_up "no line of $3 matched \"$2\" within $1 s"
}
