#!/usr/bin/env bash
# The generated part of the public header, and its implementation, are what the types' tables say.
exec "$(dirname "$0")/../tools/update_api" --check "$1"
