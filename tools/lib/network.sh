# A network of one's own for a run: only loopback, with a multicast route. Sourced.

# enter_private_network SCRIPT ARGS...: runs the script again inside such a network and does not
# return; returns where it runs inside already, or where the system allows no such network.
enter_private_network() {
  [ -n "${VANTAGE_PRIVATE_NETWORK:-}" ] && return 0
  local unshare=(unshare -n)
  [ "$(id -u)" -eq 0 ] || unshare=(unshare -Urn)
  if ! "${unshare[@]}" true 2>/dev/null; then
    echo "no private network can be made here (unshare is refused); using this machine's loopback" >&2
    return 0
  fi
  export VANTAGE_PRIVATE_NETWORK=1
  exec "${unshare[@]}" sh -c \
    'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$0" "$@"' "$@"
}
