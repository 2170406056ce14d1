# shellcheck shell=bash
# What experiments/run and tests/run share: install the packages that are missing, configure, build.
#
# Sourced, not run; the caller has set -euo pipefail and `root`, the physical path of the checkout. Standard output
# belongs to the results: every word of ours goes to standard error. What cannot be had ends in one sentence and
# exit status 69; a build that fails although everything is there is our mistake, and 70.

shopt -s extglob
: "${root:?set by the script that sources this}"

say() { printf 'polhode: %s\n' "$*" >&2; }

fail() {
  local status=$1
  shift
  say "$*"
  exit "$status"
}

# Lines of experiments/packages.txt under the given sections, comments stripped.
package_lines() {
  local line section='' wanted=" $* "
  while IFS= read -r line || [[ -n $line ]]; do
    line=${line%%#*}
    if [[ $line =~ ^\[([a-z]+)\] ]]; then
      section=${BASH_REMATCH[1]}
    elif [[ $line =~ [^[:space:]] && $wanted == *" $section "* ]]; then
      printf '%s\n' "$line"
    fi
  done <"$root/experiments/packages.txt"
}

# First choice of every line of which nothing is installed. dpkg-query is asked once for all of them.
missing_packages() {
  local lines line name names installed have
  mapfile -t lines < <(package_lines "$@")
  read -ra names <<<"${lines[*]//|/ }"
  installed=" $(dpkg-query -W -f '${Package} ${db:Status-Status}\n' "${names[@]}" 2>/dev/null |
    sed -n 's/ installed$//p' | tr '\n' ' ' || true) "
  for line in "${lines[@]}"; do
    read -ra names <<<"${line//|/ }"
    have=no
    for name in "${names[@]}"; do
      if [[ $installed == *" $name "* ]]; then have=yes; fi
    done
    if [[ $have == no ]]; then printf '%s\n' "${names[0]}"; fi
  done
}

# Installs what is missing of the given sections; silent if nothing is.
install_packages() {
  local tool missing log why
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    for tool in cmake ninja c++ pkg-config; do
      command -v "$tool" >/dev/null ||
        fail 69 "this is not Debian (no apt-get) and '$tool' is not installed; install the counterparts of:" \
          "$(package_lines "$@" | tr -s '\n ' ' ')"
    done
    return 0
  fi
  mapfile -t missing < <(missing_packages "$@")
  if ((${#missing[@]} == 0)); then return 0; fi

  local become=()
  if (($(id -u) != 0)); then
    local by_hand="run this as root, then try again: apt-get install --no-install-recommends ${missing[*]}"
    command -v sudo >/dev/null ||
      fail 69 "packages are missing, and installing them needs root or sudo; $by_hand"
    sudo -n true 2>/dev/null || [[ -t 0 ]] ||
      fail 69 "packages are missing, and sudo wants a password but there is no terminal to ask; $by_hand"
    become=(sudo)
  fi
  become+=(env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 -o Acquire::Retries=2)

  say "installing what is missing: ${missing[*]}"
  say "(what they depend on included: $(install_size "$@"))"
  log=$(mktemp) || fail 69 "cannot write a temporary file; is the disk full?"
  # A repository of somebody else that does not answer makes update fail, although ours can be had: install decides.
  "${become[@]}" update >"$log" 2>&1 </dev/null || true
  if "${become[@]}" install -y --no-install-recommends "${missing[@]}" >>"$log" 2>&1 </dev/null; then
    rm -f "$log"
    return 0
  fi
  tail -n 5 "$log" >&2 || true
  if grep -qiE 'no space left|enough free space' "$log"; then
    why="the disk is full"
  elif grep -qiE 'could not get lock|unable to (acquire|lock)' "$log"; then
    why="another program has held the package lock for five minutes"
  elif grep -qiE 'resolv|could not connect|cannot initiate|unreachable|timed out|connection failed' "$log"; then
    why="the package server cannot be reached; is there a network, or a proxy to be named in /etc/apt?"
  elif grep -qiE 'unable to locate|no installation candidate' "$log"; then
    why="this release does not have all of them; Debian 12 or later does"
  else
    why="its last words are above"
  fi
  rm -f "$log"
  fail 69 "apt-get could not install what is missing: $why"
}

# Measured on a Debian 12 that had nothing but its base.
install_size() {
  local size="up to 320 packages and 270 MB to fetch, 1.3 GB on the disk"
  if [[ " $* " == *' all '* ]]; then size="up to 465 packages and 370 MB to fetch, 1.9 GB on the disk"; fi
  printf '%s; a minute or two if the mirror is near' "$size"
}

# Sets `build_root`: build/ in the checkout, or a cache folder of this user if the checkout cannot be written.
choose_build_root() {
  build_root=$root/build
  if writable_folder "$build_root"; then return 0; fi
  local cache=${XDG_CACHE_HOME:-${HOME:-/nonexistent}/.cache} name
  name=$(printf '%s' "$root" | sha256sum)
  build_root=$cache/polhode/${name:0:12}
  writable_folder "$build_root" ||
    fail 69 "neither $root/build nor $build_root can be written (XDG_CACHE_HOME names another place)"
  say "$root/build cannot be written; building in $build_root"
}

# Also false for a build that somebody else (root, say) has left there and that we could not continue.
writable_folder() {
  mkdir -p "$1" 2>/dev/null || return 1
  local entry
  for entry in "$1" "$1"/*/ "$1"/*/CMakeCache.txt "$1"/*/build.ninja; do
    if [[ -e $entry && ! -w $entry ]]; then return 1; fi
  done
}

# How many compilers at once: one per core, but each may take 1 GB.
build_jobs() {
  local jobs=${POLHODE_JOBS:-${CMAKE_BUILD_PARALLEL_LEVEL:-}} megabytes limit
  if [[ -n $jobs ]]; then
    [[ $jobs =~ ^[1-9][0-9]{0,3}$ ]] ||
      fail 2 "POLHODE_JOBS (or CMAKE_BUILD_PARALLEL_LEVEL): got '$jobs', need a whole number from 1"
    echo "$jobs"
    return 0
  fi
  jobs=$(nproc)
  megabytes=$(sed -n 's/^MemAvailable: *\([0-9]*\)[0-9]\{3\} kB$/\1/p' /proc/meminfo 2>/dev/null || true)
  limit=$(cat /sys/fs/cgroup/memory.max 2>/dev/null || true)  # what a container may take
  if [[ $limit =~ ^[0-9]+$ ]] && ((limit / 1000000 < ${megabytes:-1000000})); then
    megabytes=$((limit / 1000000))
  fi
  if [[ -n $megabytes ]] && ((megabytes / 1000 < jobs)); then jobs=$((megabytes / 1000)); fi
  echo $((jobs > 0 ? jobs : 1))
}

# configure PRESET [-DNAME=VALUE | -DNAME?=VALUE ...]: runs CMake unless the build folder is already as asked. With
# ?= the value is for a new folder; an older one keeps its own, so that run and tests/run can share one build.
# Ninja looks after changed CMakeLists itself; a changed preset, a moved checkout and a changed -D are ours to notice.
configure() {
  local preset=$1 folder=$build_root/$1 setting needed version known='' stale=no options=()
  shift
  if [[ ! -f $folder/build.ninja || $root/CMakePresets.json -nt $folder/build.ninja ]]; then stale=yes; fi
  if [[ -f $folder/CMakeCache.txt ]]; then
    known=$(sed -n 's/^\([A-Z_]*\):[A-Z]*=/-D\1=/p' "$folder/CMakeCache.txt")
    # A cache from elsewhere, or of a configuration that failed, is not to be continued.
    if [[ ! -f $folder/build.ninja ]] || ! grep -qxF -e "-DCMAKE_HOME_DIRECTORY=$root" <<<"$known"; then
      stale=yes
      known=''
      options=(--fresh)
    fi
  fi
  for setting in "$@"; do
    if [[ $setting == *'?='* ]]; then
      if grep -q -e "^${setting%%'?='*}=" <<<"$known"; then continue; fi
      setting=${setting/'?='/=}
    fi
    options+=("$setting")
    grep -qxF -e "$setting" <<<"$known" || stale=yes
  done
  if [[ $stale == no ]]; then return 0; fi

  needed=$(sed -n 's/^cmake_minimum_required(VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")
  version=$(cmake --version | sed -n '1s/[^0-9]*\([0-9.]*\).*/\1/p')
  [[ $(printf '%s\n%s\n' "$needed" "$version" | sort -V | head -n 1) == "$needed" ]] ||
    fail 69 "CMake is too old: got $version ($(command -v cmake)), need $needed"
  if command -v ccache >/dev/null; then export CMAKE_CXX_COMPILER_LAUNCHER=ccache; fi
  mkdir -p "$folder" || fail 69 "cannot make $folder"
  (cd "$root" && cmake --preset "$preset" -B "$folder" ${options[@]+"${options[@]}"}) \
    >"$folder/configure.log" 2>&1 </dev/null && return 0
  cat "$folder/configure.log" >&2 || true
  rm -f "$folder/build.ninja"  # so that the next call tries again
  blame "$folder" "CMake could not configure; its words are above"
}

# build PRESET [TARGET...]
build() {
  local folder=$build_root/$1 target=() jobs
  shift
  if (($# > 0)); then target=(--target "$@"); fi
  jobs=$(build_jobs) || exit
  if [[ ! -e $folder/bin ]]; then say "building in $folder with $jobs compilers at once: some minutes, this once"; fi
  cmake --build "$folder" --parallel "$jobs" ${target[@]+"${target[@]}"} 2>&1 </dev/null | show_progress ||
    blame "$folder" "the build failed; the compiler's words are above"
}

# Ninja's "[n/m] ..." as one line that overwrites itself on a terminal, and not at all elsewhere; the rest as it is.
show_progress() {
  local line width=0 clear=''
  if [[ -t 2 ]]; then
    width=$(tput cols 2>/dev/null || echo 80)
    clear=$'\r\033[K'
  fi
  while IFS= read -r line; do
    if [[ $line == 'ninja: no work to do.' || -z $line ]]; then continue; fi
    if [[ $line != \[+([0-9])/* ]]; then
      printf '%s%s\n' "$clear" "$line" >&2
    elif ((width > 0)); then
      printf '%s%s' "$clear" "${line:0:width-1}" >&2
    fi
  done
  printf '%s' "$clear" >&2
}

# prepare PRESET [settings as above] -- [TARGET...]: configures and builds, one call at a time in one build folder.
prepare() {
  local preset=$1 settings=() lock
  shift
  while (($# > 0)) && [[ $1 != -- ]]; do
    settings+=("$1")
    shift
  done
  shift
  exec {lock}>"$build_root/lock"
  flock -n "$lock" || {
    say "waiting for another build in $build_root"
    flock "$lock"
  }
  configure "$preset" ${settings[@]+"${settings[@]}"}
  build "$preset" "$@"
  exec {lock}>&-
}

# Ends a build that failed: 69 where the disk is full, else 70.
blame() {
  local free
  free=$(df -Pm "$1" 2>/dev/null | sed -n '2p' | tr -s ' ' | cut -d ' ' -f 4 || true)
  if [[ $free =~ ^[0-9]+$ ]] && ((free < 50)); then
    fail 69 "the disk is full: $free MB left for $1; a build needs about 300 MB"
  fi
  fail 70 "$2"
}
