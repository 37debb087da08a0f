#!/bin/sh
# part.sh NAME K N PROGRAM: runs every Nth case of a GoogleTest program, from the Kth on (0 is the first), as ctest's test NAME. GoogleTest chooses
# the name of its report before it runs anything, so parts that begin together would write the same: each gets its own here.
case ${GTEST_OUTPUT:-} in xml:*/) export GTEST_OUTPUT="$GTEST_OUTPUT$1.xml" ;; esac
GTEST_SHARD_INDEX=$2 GTEST_TOTAL_SHARDS=$3 exec "$4"
