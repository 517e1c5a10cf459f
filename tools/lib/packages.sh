# Installs what packages.txt names. Sourced; needs $root, the project's folder.

# install_packages [bench | test | kernel]: the packages of packages.txt that are not there yet; those
# with marks only when one of these is asked for.
install_packages() {
  local wanted missing=() name
  wanted=$(sed -e 's/#.*//' "$root/packages.txt" | awk -v with="${1:-}" 'NF == 1 || $2 == with || (NF > 2 && $3 == with) { print $1 }')
  for name in $wanted; do
    dpkg-query -W -f '${db:Status-Status}\n' "$name" 2>/dev/null | grep -qx installed || missing+=("$name")
  done
  [ ${#missing[@]} -eq 0 ] && return 0
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || {
      echo "packages missing: ${missing[*]}; run as root: apt-get install --no-install-recommends ${missing[*]}" >&2
      return 2
    }
    as_root=(sudo)
  fi
  echo "Installing ${#missing[@]} Debian packages: ${missing[*]}"
  local log
  log=$(mktemp)
  if ! { "${as_root[@]}" apt-get update &&
         "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
           apt-get install -y --no-install-recommends "${missing[@]}"; } >"$log" 2>&1; then
    tail -n 20 "$log" >&2
    echo "apt-get could not install ${missing[*]}; what it printed is in $log" >&2
    return 2
  fi
  rm -f "$log"
}
