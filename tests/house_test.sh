#!/usr/bin/env bash
# The house rules that a machine can check: which room may include what, where foreign headers may appear, what lies
# at the top, how long a file may be. Prints every breach as file:line and exits 1 if there is one.
#
#   tests/house_test.sh [ROOT]
set -euo pipefail
export LC_ALL=C
cd "${1:-$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/..}"

breaches=0
# breach RULE: each line of standard input breaks it.
breach() {
  local line
  while IFS= read -r line; do
    if [[ -z $line ]]; then continue; fi
    printf '%s   (%s)\n' "$line" "$1"
    breaches=$((breaches + 1))
  done
}

# Files of the project: what git would commit, or everything but results where there is no git.
if git ls-files -z --cached --others --exclude-standard 2>/dev/null | grep -qz .; then
  mapfile -d '' -t files < <(git ls-files -z --cached --others --exclude-standard)
else
  mapfile -d '' -t files < <(find . -path ./.git -prune -o -path ./build -prune -o -path ./reports/latest -prune -o \
    -path ./polhode-results -prune -o -type f -printf '%P\0')
fi
present=()
for file in "${files[@]}"; do
  if [[ -f $file ]]; then present+=("$file"); fi
done
matching() { printf '%s\n' "${present[@]}" | grep -E "$1" || true; }
mapfile -t sources < <(matching '^(models|solvers|experiments|reports|tests)/.*\.(cpp|hpp)$')
if ((${#sources[@]} < 10)); then
  echo "only ${#sources[@]} sources found in $PWD: this is not the project"
  exit 1
fi

# Every include as: file:line header, the header in its quotes or brackets.
includes=$(grep -HnE '^ *# *include' "${sources[@]}" | sed -E 's/^([^:]*:[0-9]*): *# *include *([<"][^>"]*[>"]).*/\1 \2/')
# of ROOM-REGEX: includes in these files.   only HEADER-REGEX   and   but HEADER-REGEX: filters on the header.
of() { grep -E "^($1)" <<<"$includes" || true; }
only() { grep -E "^[^ ]* ($1)" || true; }
but() { grep -vE "^[^ ]* ($1)" || true; }

std='<[a-z_0-9]+(\.h)?>'
breach "no ../ in an include" < <(only '["<][^">]*\.\./' <<<"$includes")
breach "quoted includes start at the root of the checkout" \
  < <(only '"' <<<"$includes" | but '"(models|solvers|experiments|reports|tests)/')
breach "nothing includes tests" < <(of '(models|solvers|experiments|reports)/' | only '"tests/')
breach "models/ includes models, std, Eigen and Boost" \
  < <(of models/ | but "\"models/|$std|<(Eigen|boost|toml\+\+)/")
breach "solvers/ includes models and solvers" < <(of solvers/ | only '"' | but '"(models|solvers)/')
breach "reports/ reads result files only" < <(of reports/ | only '"' | but '"reports/')
breach "reports/ knows no mathematics" < <(of reports/ | only '<(Eigen|boost)/')

# confined HEADERS FILES: these headers appear in these files alone (and in tests, which may include anything).
confined() {
  breach "allowed only in $2" < <(only "$1" <<<"$includes" | grep -vE "^(tests/|($2):)" || true)
}
sundials='sundials|cvodes?|arkode|idas?|kinsol|nvector|sunmatrix|sunlinsol|sunnonlinsol|sunadaptcontroller'
confined "<($sundials)/" 'solvers/(sundials[a-z0-9_]*\.hpp|cvode[a-z0-9_]*\.cpp|arkode[a-z0-9_]*\.cpp)|experiments/bare_[a-z0-9_]*\.cpp'
confined '<boost/numeric/odeint' 'solvers/odeint[a-z0-9_]*\.(cpp|hpp)|experiments/bare_[a-z0-9_]*\.cpp'
confined '<(bullet/|Bullet|LinearMath/|bt[A-Z])' 'solvers/engines/bullet\.cpp|experiments/bare_[a-z0-9_]*\.cpp'
confined '<mujoco/' 'solvers/engines/mujoco\.cpp'
confined '<ode/' 'solvers/engines/ode\.cpp'
confined '<dart/' 'solvers/engines/dart\.cpp'
confined '<([Ss]imbody|SimTK)' 'solvers/engines/simbody\.cpp'
confined '<CLI/' 'experiments/polhode\.cpp'
confined '<benchmark/' 'experiments/bench\.cpp'
confined '<toml\+\+/' 'models/scene[a-z0-9_]*\.(cpp|hpp)'

headers_without_pragma() { printf '%s\0' "${sources[@]}" | grep -z '\.hpp$' | xargs -0 -r grep -L '^#pragma once$' || true; }
breach "headers start with #pragma once" < <(headers_without_pragma)

# The top of the house: rooms, and what tools look for there. Files that git does not track are their owner's affair.
if [[ -n $(git ls-files --cached 2>/dev/null || true) ]]; then
  top=$(git ls-files --cached | cut -d / -f 1 | sort -u)
else
  top=$(printf '%s\n' "${present[@]}" | cut -d / -f 1 | sort -u)
fi
breach "not a room, and no tool looks for it here" < <(grep -vxE \
  'CMakeLists\.txt|solvers|models|experiments|tests|reports|README\.md|CMakePresets\.json|LICENSE|CITATION\.cff|CHANGELOG\.md|\..*' \
  <<<"$top" || true)
breach "a name without a meaning" < <(matching '(^|/)(src|include|utils?|common|core|detail|misc|helpers?)(/|\.[a-z]+$)')

# text REGEX: where it occurs in files that people write. Patterns are in pieces, so that this file does not break
# its own rules.
mapfile -t written < <(matching '\.(cpp|hpp|def|sh|txt|cmake|json|toml|md|cff|html|css|js|gp|py)$|/run$|^\.clang|^LICENSE$')
text() { grep -HnE -e "$1" /dev/null "${written[@]}" | cut -c 1-160 || true; }
breach "unfinished" < <(text '\b(TO''DO|FIX''ME|X''XX)\b')
breach "a path of somebody's machine" < <(text '(^|[^A-Za-z0-9_./-])/(home|work|Users|root)(/|[^A-Za-z0-9_-]|$)')
mapfile -t written < <(matching '(^|/)(CMakeLists\.txt|CMakePresets\.json)$|\.cmake$')
breach "no fast-math: results must not depend on the compiler" \
  < <(text '-(O''fast|ff''ast-math|funsafe-math)|-ffp-contract=(on|fast)' | grep -vE '^[^:]*:[0-9]*: *#' || true)
mapfile -t written < <(matching '^tests/.*\.(cpp|hpp)$')
breach "tests are neither skipped nor disabled" < <(text 'GTEST_''SKIP|DIS''ABLED_')

# Long files hide their parts. Data, and pages that polhode wrote, may be long.
for file in $(matching '\.(cpp|hpp|def|sh|cmake|css|js|gp|py)$|CMakeLists\.txt$|/run$|^reports/[^/]*\.html$'); do
  lines=$(wc -l <"$file")
  if ((lines > 500)); then breach "at most 500 lines" <<<"$file: $lines lines"; fi
done

for file in experiments/run tests/run .ci/run $(matching '^tests/.*_test\.sh$'); do
  if [[ ! -x $file ]]; then breach "scripts can be run" <<<"$file"; fi
done

if ((breaches > 0)); then
  echo "$breaches breaches of the house rules"
  exit 1
fi
echo "the house is in order: ${#present[@]} files, $(wc -l <<<"$includes") includes"
