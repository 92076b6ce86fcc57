cd /tmp/wt/review6; flock -s /tmp/wt/heavy.lock env RUST_BACKTRACE=0 cargo test -p ipc-contact --test review -- --test-threads=2 "$@" 2>&1 | grep -v "^warning\|^ *|" | tail -80; date
