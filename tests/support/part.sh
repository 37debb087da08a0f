#!/bin/sh
# part.sh K N PROGRAM: runs every Nth case of a GoogleTest program, from the Kth on (0 is the first), for ctest. GoogleTest chooses the name of its
# report before it runs anything, so parts that begin together would write the same: each gets its own here, as tally.mjs expects it.
name=$(basename "$3")
[ "$1" -eq 0 ] || name=${name}_$1
case ${GTEST_OUTPUT:-} in xml:*/) export GTEST_OUTPUT="$GTEST_OUTPUT$name.xml" ;; esac
GTEST_SHARD_INDEX=$1 GTEST_TOTAL_SHARDS=$2 exec "$3"
