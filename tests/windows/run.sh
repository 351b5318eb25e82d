#!/bin/bash
# Runs admire as programs of Windows, under Wine, and holds them to what they do on Linux.
#
#   tests/windows/run.sh             all parts
#   tests/windows/run.sh shims text  some of them: libraries unit dropin shims names corpus motion toolkit interrupt text
#
# SHARED names the folder of reference material (../shared without it). Needs the Debian packages gcc-mingw-w64-x86-64, wine and wine64
# (8.0 is enough), and rustup. PROFILE=release tries that build.
# Wine before 9 lacks bcryptprimitives.dll; process_prng.c stands in for it. All files are made below target/.
#
# What differs from Linux by intent is taken off before files are compared: CR at line ends of the files of a run, paths, dates, times,
# names of computers. The page `windows` of the guide lists it.
set -euo pipefail
cd "$(dirname "$0")/../.."
root=$PWD
exec </dev/null

target=x86_64-pc-windows-gnu
profile=${PROFILE:-dev}
shared=${SHARED:-../shared}
built=$([ "$profile" = dev ] && echo debug || echo "$profile")
work=$root/target/windows-run
export WINEPREFIX=$root/target/wine WINEDEBUG=-all WINEDLLOVERRIDES="mscoree,mshtml="
export CARGO_TARGET_X86_64_PC_WINDOWS_GNU_RUNNER=wine

for program in wine x86_64-w64-mingw32-gcc rustup; do
    command -v "$program" >/dev/null || {
        echo "$program is missing: apt-get install gcc-mingw-w64-x86-64 wine wine64"
        exit 2
    }
done

parts=("$@")
((${#parts[@]})) || parts=(libraries unit dropin shims names corpus motion toolkit interrupt text)
failures=0

failed() {
    echo "FAILED: $*"
    failures=$((failures + 1))
}

stage() {
    printf '\n==== %s (%d s)\n' "$*" "$SECONDS"
}

# A path as Windows has it.
windows() {
    printf 'Z:%s' "${1//\//\\}"
}

# Lines of cmd, with the shims first on the PATH; the exit code is that of the last line.
cmd() {
    { printf '@echo off\r\n'; printf '%s\r\n' "$@"; } >"$work/script.bat"
    WINEPATH=$(windows "$work/bin") wine cmd /c "$(windows "$work/script.bat")"
}

# Compares a file with that of Linux, but for what must differ.
same() {
    local linux=$1 windows=$2 found
    if [ ! -f "$windows" ]; then
        failed "$windows was not written"
    elif found=$(python3 - "$linux" "$windows" 2>&1 <<'PYTHON'
import re, sys

def pieces(path):
    text = open(path, "rb").read().decode("latin-1").replace("\r", "").replace("\\\\", "/").replace("\\", "/")
    text = text.replace("Z:/", "/").replace("windows-run/windows", "windows-run/linux")
    text = re.sub(r"\d{4}-\d\d-\d\d[ T][0-9:]{8}([+-][0-9:]+|Z)?", "DATE", text)
    text = re.sub(r"<(Author|Environment|File) [^>]*>", "RUN", text)
    # The last column of a simulation is processor time.
    text = re.sub(r"(?m)^((?: +\d\.\d+E[-+]\d+){2}(?: +\d+){3}) +\d+\.\d+ *$", r"\1", text)
    text = re.sub(r"(Elapsed time|CPU time|[Cc]urrent dir|Host|Process).*", "RUN", text)
    return re.split(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)", text)

ours, theirs = pieces(sys.argv[1]), pieces(sys.argv[2])
largest, kinds = 0.0, 0
for a, b in zip(ours, theirs):
    if a == b:
        continue
    try:
        x, y = float(a), float(b)
    except ValueError:
        sys.exit(f"`{a[-60:]}` and `{b[-60:]}`")
    apart = abs(x - y) / max(abs(x), abs(y), 1e-6)
    largest, kinds = max(largest, apart), kinds + 1
if len(ours) != len(theirs):
    sys.exit(f"{len(ours)} and {len(theirs)} pieces")
if kinds:
    sys.exit(f"{kinds} numbers apart by {largest:.0e} at most")
PYTHON
    ); then
        echo "same: ${windows#"$work/"}"
    else
        failed "$windows differs from $linux: $found"
    fi
}

stage "build"
tests=(cargo test --profile "$profile" --target "$target")
cargo build --profile "$profile"
"${tests[@]}" --no-run --test dropin
exe=$root/target/$target/$built
linux=$root/target/$built
rm -rf "$work"
mkdir -p "$work/linux" "$work/windows" "$work/bin"
wineboot -i
if [ ! -f "$WINEPREFIX/drive_c/windows/system32/bcryptprimitives.dll" ]; then
    x86_64-w64-mingw32-gcc -shared -O1 -o "$WINEPREFIX/drive_c/windows/system32/bcryptprimitives.dll" \
        tests/windows/process_prng.c -ladvapi32
fi
x86_64-w64-mingw32-gcc -municode -O1 -o "$work/system_line.exe" tests/windows/system_line.c
wine "$exe/admire.exe" install-shims "$(windows "$work/bin")" >"$work/installed"
wine "$exe/admire.exe" install-shims "$(windows "$work/b in")" --names mdi >>"$work/installed"

libraries() {
    for program in admire mdi; do
        needed=$(x86_64-w64-mingw32-objdump -p "$exe/$program.exe" | sed -n 's/.*DLL Name: //p' | tr 'A-Z' 'a-z' | sort)
        echo "$program.exe needs" $needed
        for library in $needed; do
            case $library in
            libgcc* | libwinpthread* | libstdc* | cyg* | msys*) failed "$program.exe needs $library" ;;
            esac
        done
    done
}

# Runs tests of one target: its option, then the names. Under load Wine now and then cannot start a process and says 1359, "Internal
# error"; tests that all failed by that, and by nothing else, are run once more.
tested() {
    local option=$1 said=$work/tested names
    shift
    "${tests[@]}" $option -- "$@" 2>&1 | tee "$said" && return
    names=$(sed -n 's/\r$//; s/^test \(.*\) \.\.\. FAILED$/\1/p' "$said")
    [ -n "$names" ] || return 1
    for name in $names; do
        sed -n "/^---- $name stdout ----/,/^\(---- \|failures:\)/p" "$said" | grep -q 'code: 1359\|os error 1359' || return 1
    done
    echo "AGAIN, since Wine could not start a process (1359):" $names
    "${tests[@]}" $option -- --exact $names
}

unit() {
    tested --lib text:: backend:: session:: cli:: front:: || failed "unit tests"
}

dropin() {
    tested "--test dropin" || failed "tests/dropin"
}

shims() {
    [ ! -e "$work/bin/mdi" ] || failed "install-shims wrote a script that Windows cannot run"
    local there="$work/windows/my runs (1)" name
    mkdir -p "$there"
    printf 'A slider on a spring\r\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\r\nPART/1, GROUND\r\nMARKER/1, PART=1\r\nPART/2, MASS=2, CM=20, IP=100, 100, 100\r\nMARKER/20, PART=2\r\nMARKER/21, PART=2, QP=0, 0, 50\r\nMARKER/11, PART=1, QP=0, 0, -50\r\nJOINT/1, TRANSLATIONAL, I=20, J=1\r\nSPRINGDAMPER/1, TRANSLATIONAL, I=21, J=11, K=10, LENGTH=100\r\nSFORCE/1, TRANSLATIONAL, ACTIONONLY, I=20, J=1, FUNCTION=5\r\nRESULTS/FORMATTED, XRF\r\nEND\r\n' >"$there/the slider.adm"
    printf '\r\nfile/model=%s\\THE SLIDER\r\nsimulate/static\r\nstop\r\n' "$(windows "$there")" >"$there/a run.acf"
    printf '\r\nfile/model=the slider\r\nsimulate/static\r\nstop\r\n' >"$there/run.acf"
    solved() {
        grep -q "^0.5 \|[ ^]0\.5 " "$there"/*.res || failed "$1 has no answer"
        rm -f "$there"/*.res "$there"/*.msg
    }
    cd_there="cd /d \"$(windows "$there")\""
    for name in mdi mdi.bat MDI.BAT adams2016.bat adams2024_1 adams2024_1.bat adams2025_1.bat; do
        cmd "$cd_there" "call $name -c ru-standard i run.acf exit" >"$work/said" || failed "$name: $(tail -1 "$work/said")"
        solved "$name"
    done
    # As MATLAB's system() and dos() do: one line for `cmd /c`, quotes inside. If it begins with a quote and has more of them, cmd takes
    # off the first and the last.
    line() {
        printf '%s\n' "$1" >"$work/line"
        (cd "$there" && WINEPATH=$(windows "$work/bin") wine "$work/system_line.exe" "$(windows "$work/line")" >"$work/said")
    }
    for words in \
        'mdi.bat -c ru-standard i "a run.acf" exit' \
        'mdi -c ru-standard i "a run.acf" exit' \
        'adams2024_1.bat ru-s b .\RUN' \
        "mdi.bat -c ru-standard i \"$(windows "$there")\\a run.acf\" exit" \
        "\"$(windows "$work/bin")\\mdi.bat\" -c ru-standard i run.acf exit" \
        "\"\"$(windows "$work/b in")\\mdi.bat\" -c ru-standard i \"$(windows "$there")\\a run.acf\" exit\""; do
        line "$words" || failed "$words: $(tail -1 "$work/said")"
        solved "$words"
    done
    # Exit codes come through the batch file.
    local code=0
    line 'mdi.bat -c ru-user i lib run.acf exit' || code=$?
    [ "$code" = 2 ] || failed "exit code $code instead of 2"
    # Folders whose letters the code page of the console spells otherwise.
    local odd="$work/windows/Jürgen"
    mkdir -p "$odd/100%"
    cp "$exe/admire.exe" "$exe/mdi.exe" "$odd/100%/"
    wine "$odd/100%/admire.exe" install-shims "$(windows "$odd")\\bin" --names odd >/dev/null || failed "install-shims below $odd"
    (cd "$there" && WINEPATH=$(windows "$odd/bin") wine cmd /c odd.bat -c ru-standard i run.acf exit >"$work/said") ||
        failed "a shim below $odd: $(tail -1 "$work/said")"
    solved "a shim below a folder with an umlaut"
    echo "shims: done"
}

# Files that a study names in other letters, and files of two names.
names() {
    local side
    for side in linux windows; do
        cp -r corpus/pseudo-mcpherson "$work/$side/letters"
        sed -i 's/"model.adm"/"MODEL.Adm"/; s/"reference.adm"/"Reference.ADM"/; s/"\([a-z_]*\)\.csv"/"\U\1\E.CSV"/g' "$work/$side/letters/study.toml"
    done
    grep -q '"MODEL.Adm"' "$work/linux/letters/study.toml" || failed "the study names its deck otherwise"
    (cd "$work/linux" && "$linux/admire" identify letters --out lettered >lettered.txt 2>lettered.err) || failed "letters on Linux"
    (cd "$work/windows" && wine "$exe/admire.exe" identify letters --out lettered >lettered.txt 2>lettered.err) || failed "letters"
    same "$work/linux/lettered/identified.adm" "$work/windows/lettered/identified.adm"
    same "$work/linux/lettered.txt" "$work/windows/lettered.txt"
    cp corpus/pseudo-mcpherson/model.adm "$work/windows/first.adm"
    ln "$work/windows/first.adm" "$work/windows/second.adm"
    (cd "$work/windows" && wine "$exe/admire.exe" set first.adm BUSHING/1.K.1=1234 --in-place >/dev/null) || failed "a file of two names"
    grep -q 1234 "$work/windows/second.adm" || failed "the second name shows the old text"
    cmp "$work/windows/first.adm" "$work/windows/second.adm" || failed "two names, two texts"
    ls "$work/windows/"*.whole-* 2>/dev/null && failed "a text is left beside"
    echo "names: done"
}

corpus() {
    local name command deck side file method
    # The tests leave folders of runs that failed, on purpose.
    rm -rf "$WINEPREFIX"/drive_c/users/*/Temp/admire-run-*
    for command in identify diagnose; do
        (cd "$work/linux" && "$linux/admire" "$command" "$root/corpus/pseudo-mcpherson" --out "$command" >"$command.txt" 2>"$command.err") ||
            failed "$command on Linux"
        (cd "$work/windows" && wine "$exe/admire.exe" "$command" "$(windows "$root/corpus/pseudo-mcpherson")" --out "$command" >"$command.txt" 2>"$command.err") ||
            failed "$command"
        (cd "$work/linux/$command" && find . -type f | sort) | while read -r name; do
            case $name in
            # It lists SHA-256 of files that name their folders.
            */admire-outputs.json) continue ;;
            esac
            echo "$name"
        done >"$work/names"
        while read -r name; do
            same "$work/linux/$command/${name#./}" "$work/windows/$command/${name#./}"
        done <"$work/names"
        same "$work/linux/$command.txt" "$work/windows/$command.txt"
    done
    # Runs of the reference decks, file by file.
    for deck in multilink/ocp_ref pseudo-mcpherson/mcph_ref; do
        [ -f "$shared/reference/$deck.acf" ] || {
            echo "SKIPPED: $shared/reference/$deck.acf is not here"
            continue
        }
        name=$(basename "$deck")
        for side in linux windows; do
            mkdir -p "$work/$side/$name"
            cp "$shared/reference/$deck".{adm,acf} "$work/$side/$name/"
        done
        (cd "$work/linux/$name" && "$linux/mdi" -c ru-standard i "$name.acf" exit >/dev/null) || failed "$name on Linux"
        (cd "$work/windows/$name" && wine "$exe/mdi.exe" -c ru-standard i "$name.acf" exit >/dev/null) || failed "$name"
        for file in "$work/linux/$name"/*; do
            same "$file" "$work/windows/$name/$(basename "$file")"
        done
    done
    # Characteristics of an axle.
    local axle=$root/corpus/multilink
    (cd "$work/linux" && "$linux/admire" kc "$axle/model.adm" --config "$axle/kc.toml" --out kc >kc.txt) || failed "kc on Linux"
    (cd "$work/windows" && wine "$exe/admire.exe" kc "$(windows "$axle/model.adm")" --config "$(windows "$axle/kc.toml")" \
        --out kc >kc.txt) || failed "kc"
    for file in "$work/linux/kc"/*; do
        case $file in
        */admire-outputs.json) ;;
        *) same "$file" "$work/windows/kc/$(basename "$file")" ;;
        esac
    done
    same "$work/linux/kc.txt" "$work/windows/kc.txt"
    # The same study through mdi.bat as the external program, found by its bare name.
    cp -r corpus/pseudo-mcpherson "$work/windows/external"
    printf '\n[solver]\nbackend = "command"\ntimeout_s = 120\n' >>"$work/windows/external/study.toml"
    cmd "cd /d \"$(windows "$work/windows")\"" "\"$(windows "$exe/admire.exe")\" identify external --out identified" >"$work/said" 2>&1 ||
        failed "a study with mdi.bat: $(tail -3 "$work/said")"
    cp -r "$work/windows/external" "$work/linux/external"
    (cd "$work/linux" && PATH="$linux:$PATH" "$linux/admire" identify external --out identified) >"$work/said" 2>&1 || failed "a study with mdi on Linux"
    same "$work/linux/identified/identified.adm" "$work/windows/identified/identified.adm"
    # The other methods: singular values, and the paper's loop.
    for method in direct regression; do
        (cd "$work/linux" && "$linux/admire" identify "$root/corpus/pseudo-mcpherson" --method "$method" --out "$method" \
            >"$method.txt" 2>"$method.err") || failed "$method on Linux"
        (cd "$work/windows" && wine "$exe/admire.exe" identify "$(windows "$root/corpus/pseudo-mcpherson")" --method "$method" \
            --out "$method" >"$method.txt" 2>"$method.err") || failed "$method"
        for name in identified.adm identification.json; do
            same "$work/linux/$method/$name" "$work/windows/$method/$name"
        done
        same "$work/linux/$method.txt" "$work/windows/$method.txt"
    done
    ls -d "$WINEPREFIX"/drive_c/users/*/Temp/admire-run-* 2>/dev/null && failed "folders of runs are left"
    return 0
}

# Simulations over time: a crank that drives a block on a spring through a rod, with friction, then its modes.
motion() {
    local side name
    for side in linux windows; do
        mkdir -p "$work/$side/motion"
        cat >"$work/$side/motion/crank.adm" <<'DECK'
A crank, a rod and a block
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1, REULER=0D, 0D, 0D
MARKER/2, PART=1, REULER=90D, 90D, 0D
MARKER/3, PART=1, QP=400, 0, 0
PART/2, MASS=1.5, CM=20, IP=2000, 2000, 3000
MARKER/20, PART=2, QP=30, 0, 0
MARKER/21, PART=2
MARKER/22, PART=2, QP=60, 0, 0
PART/3, QG=60, 0, 0, MASS=0.7, CM=30, IP=100, 4000, 4000
MARKER/30, PART=3, QP=100, 0, 0
MARKER/31, PART=3
MARKER/32, PART=3, QP=200, 0, 0
PART/4, QG=260, 0, 0, MASS=2, CM=40, IP=900, 900, 900
MARKER/40, PART=4
MARKER/41, PART=4, REULER=90D, 90D, 0D
JOINT/1, REVOLUTE, I=21, J=1
JOINT/2, SPHERICAL, I=22, J=31
JOINT/3, UNIVERSAL, I=33, J=42
MARKER/33, PART=3, QP=200, 0, 0, REULER=0D, 0D, 0D
MARKER/42, PART=4, REULER=0D, 90D, 0D
JOINT/4, TRANSLATIONAL, I=41, J=2
SPRINGDAMPER/1, TRANSLATIONAL, I=40, J=3, K=2, C=0.05, LENGTH=130
SFORCE/1, ROTATIONAL, ACTIONONLY, I=21, J=1, FUNCTION=4000*SIN(7*TIME)*EXP(-0.3*TIME)+STEP(TIME,0,0,0.2,900)
ACCGRAV/JGRAV=-9810
RESULTS/FORMATTED, XRF
END
DECK
        printf '\nfile/model=crank\nSIM/DYN, END=0.8, STEPS=80\nLINEAR/EIGENSOL\nSTOP\n' >"$work/$side/motion/run.acf"
    done
    (cd "$work/linux/motion" && "$linux/mdi" -c ru-standard i run.acf exit >said.txt) || failed "motion on Linux: $(tail -4 "$work/linux/motion/said.txt")"
    (cd "$work/windows/motion" && wine "$exe/mdi.exe" -c ru-standard i run.acf exit >said.txt) || failed "motion"
    for name in "$work/linux/motion"/*; do
        same "$name" "$work/windows/motion/$(basename "$name")"
    done
}

toolkit() {
    local decks=$shared/real-decks file name extension
    [ -d "$decks" ] || {
        echo "SKIPPED: $decks is not here"
        return 0
    }
    for side in linux windows; do
        cp -r "$decks" "$work/$side/decks"
    done
    both() {
        (cd "$work/linux" && "$linux/admire" "$@" >out.txt 2>err.txt) || true
        (cd "$work/windows" && wine "$exe/admire.exe" "$@" >out.txt 2>err.txt) || true
        # Under load Wine 8 sometimes reports a fault of its own (`wine: Unhandled page fault`), and does not when asked again: once more.
        if grep -aq '^wine: ' "$work/windows/err.txt"; then
            echo "AGAIN: $(grep -am 1 '^wine: ' "$work/windows/err.txt")"
            (cd "$work/windows" && wine "$exe/admire.exe" "$@" >out.txt 2>err.txt) || true
        fi
        same "$work/linux/out.txt" "$work/windows/out.txt"
        same "$work/linux/err.txt" "$work/windows/err.txt"
    }
    (cd "$work/linux" && find decks -iname '*.adm' | sort) >"$work/names"
    while read -r name; do
        echo "-- $name"
        both check --format plain "$name"
        both export "$name" --json
        both fix --unsafe --write "$name"
        both renumber "$name" MARKER=500000 -o "$name.new"
    done <"$work/names"
    (cd "$work/linux" && find decks -iname '*.res' -o -iname '*.req' -o -iname '*.msg' -o -iname '*.acf' | sort) >"$work/names"
    while read -r name; do
        echo "-- $name"
        case $name in
        *.acf) both check --format plain "$name" ;;
        *) both results "$name" ;;
        esac
    done <"$work/names"
    # Decks that were rewritten are the same to the byte, with the line ends they had.
    (cd "$work" && diff -rq linux/decks windows/decks) || failed "files of the two sides differ"
    echo "$(find "$work/windows/decks" -name '*.new' | wc -l) decks rewritten"
}

# Ctrl-C and Ctrl-Break ask to stop, a second one gives up at once, and the external program ends too.
interrupt() {
    cp -r corpus/pseudo-mcpherson "$work/windows/slow"
    printf '\n[solver]\nbackend = "command"\ncommand = ["slow.bat", "{acf}"]\ntimeout_s = 600\n' >>"$work/windows/slow/study.toml"
    printf '@echo off\r\n:again\r\necho x>>"%s"\r\ngoto again\r\n' "$(windows "$work/beat")" >"$work/bin/slow.bat"
    x86_64-w64-mingw32-gcc -municode -O1 -o "$work/ctrl_break.exe" tests/windows/ctrl_break.c
    # Only a terminal is a console. Of its keys only Ctrl-C is known to Wine; the other one is given by a program.
    interrupted Ctrl-C "wine '$exe/admire.exe' identify slow --out never -q" '\003'
    interrupted Ctrl-Break "wine '$work/ctrl_break.exe' 12 3 '$exe/admire.exe' identify slow --out never -q" ''
    echo "interrupt: done"
}

interrupted() {
    local what=$1 line=$2 key=$3 size
    rm -f "$work/beat"
    (sleep 12; printf "$key"; sleep 3; printf "$key"; sleep 6) | (
        cd "$work/windows" && WINEPATH=$(windows "$work/bin") timeout 60 script -qec "$line; echo exit code \$?" /dev/null
    ) >"$work/said" 2>&1 || true
    grep -aq 'stopping after this step' "$work/said" || failed "$what is not answered"
    grep -aq 'exit code 130' "$work/said" || failed "a second $what does not give up: $(tail -1 "$work/said")"
    [ -s "$work/beat" ] || failed "the external program was not started"
    sleep 2
    size=$(stat -c %s "$work/beat")
    sleep 2
    [ "$size" = "$(stat -c %s "$work/beat")" ] || failed "the external program goes on after $what"
    [ ! -e "$work/windows/never" ] || failed "outputs of a run that was given up"
}

text() {
    printf 'L\344ngslenker \260\r\nPART/1, GROUND\r\n! adams_view_name=%s\r\nPART/2, MASS=1, CM=3\r\nFOO/1\r\nEND\r\n' "'L\344ngslenker'" >"$work/windows/latin1.adm"
    cp "$work/windows/latin1.adm" "$work/linux/"
    for page in 65001 850 1252; do
        (cd "$work/linux" && ADMIRE_CODE_PAGE=$page "$linux/admire" check latin1.adm >"$page.txt" 2>&1) || true
        cmd "chcp $page >nul" "cd /d \"$(windows "$work/windows")\"" "set ADMIRE_CODE_PAGE=$page" "\"$(windows "$exe/admire.exe")\" check latin1.adm > $page.txt 2>&1" || true
        cmp "$work/linux/$page.txt" "$work/windows/$page.txt" || failed "text in code page $page"
        grep -q panicked "$work/windows/$page.txt" && failed "panic in code page $page"
        ! grep -q $'\033' "$work/windows/$page.txt" || failed "colours on a pipe"
    done
    iconv -f UTF-8 "$work/windows/65001.txt" >/dev/null || failed "no UTF-8"
    iconv -f CP1252 -t UTF-8 "$work/windows/1252.txt" | grep -q 'Längslenker\|latin1' || failed "no text in 1252"
    echo "text: done"
}

for part in "${parts[@]}"; do
    stage "$part"
    "$part"
done
wineserver -k || true
stage "done"
[ "$failures" = 0 ] || {
    echo "$failures failures"
    exit 1
}
echo passed
