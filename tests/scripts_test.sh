#!/usr/bin/env bash
# What experiments/run says and does when something is missing, and that it passes on what it is given.
#
# A project with two scripts and no sources, and a PATH of its own in which apt-get, sudo, cmake and so on are stand-ins
# that play the trouble: nothing is installed and nothing is compiled. Ends with "N passed, N failed".
#
#   tests/scripts_test.sh [ROOT]
set -euo pipefail
root=$(cd "${1:-$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/..}" && pwd -P)
unset POLHODE_JOBS CMAKE_BUILD_PARALLEL_LEVEL XDG_CACHE_HOME

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
scratch=$(readlink -f "$scratch")
project="$scratch/a b/pol'hode"  # with the characters that break careless scripts
bin=$scratch/bin
home=$scratch/home
passed=0
failed=0

# stub NAME: a stand-in command from standard input.
stub() {
  rm -f "$bin/$1"  # never write through a link to the real one
  { echo '#!/bin/bash'; cat; } >"$bin/$1"
  chmod +x "$bin/$1"
}

# A machine on which everything is there: cmake leaves a `polhode` that tells how it was called.
healthy() {
  rm -rf "$scratch/a b" "$bin" "$home"
  mkdir -p "$project/experiments" "$project/reports" "$bin" "$home"
  cp "$root"/experiments/{run,setup.sh,packages.txt} "$project/experiments/"
  echo 'cmake_minimum_required(VERSION 3.22)' >"$project/CMakeLists.txt"
  echo '{}' >"$project/CMakePresets.json"
  local tool
  for tool in bash cat chmod cut df dirname env flock grep head mkdir mktemp nproc readlink rm sed sha256sum sort tail touch tr; do
    ln -s "$(command -v "$tool")" "$bin/$tool"
  done
  stub id <<<'echo 0'
  stub dpkg-query <<<'for name in "${@:4}"; do echo "$name installed"; done'
  stub apt-get <<<"echo \"\$*\" >>'$scratch/apt'"
  stub ninja <<<''
  stub c++ <<<''
  stub pkg-config <<<''
  stub cmake <<'STUB'
case $1 in
  --version) echo 'cmake version 3.25.1' ;;
  --preset)
    echo configure >>"$4/calls"
    echo "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD" >"$4/CMakeCache.txt"
    for setting in "${@:5}"; do sed 's/^-D//; s/=/:BOOL=/' <<<"$setting" >>"$4/CMakeCache.txt"; done
    touch "$4/build.ninja"
    ;;
  --build)
    echo '[1/1] Linking'
    mkdir -p "$2/bin"
    printf '%s\n' '#!/bin/bash' 'pwd' 'printf "<%s>\n" "$@"' 'exit 42' >"$2/bin/polhode"
    chmod +x "$2/bin/polhode"
    ;;
esac
STUB
  rm -f "$scratch/apt"
}

missing() { stub dpkg-query <<<'exit 1'; }

# expect WHAT STATUS TEXT COMMAND...: runs with that PATH alone and no terminal; TEXT has to be in what it says.
expect() {
  local what=$1 status=$2 text=$3 got=0 words
  shift 3
  words=$(cd "$scratch" && PATH=$bin HOME=$home "$@" 2>&1 </dev/null) || got=$?
  if [[ $got == "$status" && $words == *"$text"* ]]; then
    passed=$((passed + 1))
  else
    failed=$((failed + 1))
    printf '%s: got status %s, need %s; need the words "%s"; it said:\n%s\n\n' "$what" "$got" "$status" "$text" "$words"
  fi
}

# holds WHAT COMMAND...
holds() {
  local what=$1
  shift
  if "$@"; then passed=$((passed + 1)); else
    failed=$((failed + 1))
    printf '%s: does not hold\n' "$what"
  fi
}

run=$project/experiments/run

healthy
expect "arguments arrive whole, in the caller's folder" 42 "$scratch
<a b>
<*>
<>" "$run" 'a b' '*' ''
expect "no arguments: the study" 42 "$project
<study>
<-o>
<reports/latest>" "$run"
holds "nothing is installed where all is there" test ! -e "$scratch/apt"
holds "configured once" test "$(cat "$project/build/release/calls")" = configure
ln -s "$run" "$scratch/link"
expect "called through a link" 42 '<list>' "$scratch/link" list
holds "still configured once" test "$(cat "$project/build/release/calls")" = configure
touch -d '1 hour' "$project/CMakePresets.json"
expect "a changed preset" 42 '<list>' "$run" list
holds "configures again" test "$(wc -l <"$project/build/release/calls")" = 2
words=$(cd "$scratch" && PATH=$bin HOME=$home "$run" list 2>/dev/null </dev/null || true)
holds "standard output is polhode's alone" test "$words" = "$scratch
<list>"
mv "$project" "$project-moved"
expect "a checkout that was moved" 42 '<list>' "$project-moved/experiments/run" list
holds "configures afresh" grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$project-moved" "$project-moved/build/release/CMakeCache.txt"

touch -d '1 hour ago' "$project-moved/CMakePresets.json"
cache=$project-moved/build/release/CMakeCache.txt
holds "without tests, which would need more packages" grep -qx 'BUILD_TESTING:BOOL=OFF' "$cache"
sed -i 's/^BUILD_TESTING.*/BUILD_TESTING:BOOL=ON/' "$cache"
expect "a build that tests/run has made" 42 '<list>' "$project-moved/experiments/run" list
holds "is used as it is" grep -qx 'BUILD_TESTING:BOOL=ON' "$cache"

healthy
missing
expect "packages are installed" 42 'installing what is missing: cmake ninja-build' "$run" list
holds "by one update and one install" test "$(grep -cE ' (update|install) ?' "$scratch/apt")" = 2
holds "without what they only recommend" grep -q -- 'install -y --no-install-recommends cmake ' "$scratch/apt"

healthy
stub dpkg-query <<<'for name in "${@:4}"; do case $name in gnuplot-nox|cmake) ;; *) echo "$name installed";; esac; done'
expect "another gnuplot will do" 42 'installing what is missing: cmake' "$run" list

healthy
missing
stub id <<<'echo 1000'
expect "neither root nor sudo" 69 'needs root or sudo; run this as root, then try again: apt-get install' "$run" list
stub sudo <<<'exit 1'
expect "sudo without a terminal" 69 'sudo wants a password but there is no terminal' "$run" list
stub sudo <<<'if [[ $1 == -n ]]; then exit 0; fi; exec "$@"'
expect "sudo without a password" 42 '<list>' "$run" list

# trouble WORDS SENTENCE: apt-get ends with these words.
trouble() {
  healthy
  missing
  stub apt-get <<<"echo \"$1\"; exit 100"
  expect "apt-get: $1" 69 "$2" "$run" list
}
trouble "Temporary failure resolving 'deb.debian.org'" "the package server cannot be reached"
trouble "E: Unable to locate package libtomlplusplus-dev" "Debian 12 or later does"
trouble "E: You don't have enough free space in /var/cache/apt/archives/." "the disk is full"
trouble "E: Could not get lock /var/lib/dpkg/lock-frontend" "held the package lock"
trouble "E: Sub-process returned an error code" "its last words are above"

healthy
rm "$bin/apt-get" "$bin/dpkg-query"
expect "another system with all tools" 42 '<list>' "$run" list
rm "$bin/ninja"
expect "another system without Ninja" 69 "this is not Debian (no apt-get) and 'ninja' is not installed" "$run" list

healthy
touch "$project/build"  # in the way, which also stops root
expect "a checkout that cannot be written" 42 "cannot be written; building in $home/.cache/polhode/" "$run" list
touch "$home/file"
expect "no place at all" 69 "can be written (XDG_CACHE_HOME names another place)" \
  env XDG_CACHE_HOME="$home/file" "$run" list

healthy
stub cmake <<<'echo "cmake version 3.18.4"'
expect "an old CMake" 69 'CMake is too old: got 3.18.4' "$run" list

healthy
sed -i "s/^    echo '\[1.*/    echo error: nonsense; exit 1/" "$bin/cmake"
expect "a build that fails" 70 'error: nonsense' "$run" list
stub df <<<'printf "Filesystem\n/dev/x 100 98 2 98%% /\n"'
expect "a full disk" 69 'the disk is full: 2 MB left' "$run" list

healthy
expect "a senseless number of jobs" 2 "got 'many', need a whole number from 1" env POLHODE_JOBS=many "$run" list

printf '%d passed, %d failed\n' "$passed" "$failed"
((failed == 0))
