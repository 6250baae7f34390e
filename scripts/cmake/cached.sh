#!/bin/sh
# cached.sh COMPILER ARGUMENT...: compiles by ccache, so that what another clone or preset has compiled from the same text
# is not compiled again. Paths are hashed as seen from the build's folder, so that two clones share.
CCACHE_BASEDIR=$(dirname "$(dirname "$(dirname "$(realpath "$0")")")")
export CCACHE_BASEDIR CCACHE_NOHASHDIR=1 CCACHE_SLOPPINESS=pch_defines,time_macros
case " $* " in
  *" c++-header "*)
    # Where an older precompiled header exists, the preprocessor names it in place of the text that ccache hashes. That
    # text has no comments, but the compiler compares whole files to include each once, so they are hashed instead.
    export CCACHE_DEPEND=1
    for word; do
      case $word in *.gch | *.pch) rm -f -- "$word" ;; esac
    done
    ;;
esac
exec ccache "$@"
