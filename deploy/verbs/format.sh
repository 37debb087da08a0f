# shellcheck shell=bash
# lays out the C++ sources with clang-format 14, the console's with Prettier
#
# options: --check      change nothing; name the files that differ and fail
#          --no-setup   leave the machine as it is
# shellcheck source=deploy/lib/lint.sh
source deploy/lib/lint.sh
check=
for option in "$@"; do
  case $option in
    --check) check=yes ;;
    *) common_option format "$option" ;;
  esac
done
setup check
formatter=$(find_clang_format) || die "$(no_clang_format)"
if [ -n "$check" ]; then
  cpp_files | xargs -0 "$formatter" --dry-run -Werror
  check_console_layout
else
  cpp_files | xargs -0 "$formatter" -i
  (cd web && node_modules/.bin/prettier --write --log-level warn .)
fi
