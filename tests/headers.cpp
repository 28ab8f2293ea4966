// CMake precompiles headers for targets with a source only.
