// The source of the precompiled headers of the tests (tests/CMakeLists.txt): CMake wants one.
