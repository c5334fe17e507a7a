#!/bin/sh
# Draws docs/images/deviation.png, how far a coarse model is from the scan that it stands for, with the command that
# is given. Run by `make doc-images`.
set -eu
halfline=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$halfline" generate scan -n 1M -o "$folder/scan.ply" --quiet
"$halfline" generate scan -n 60k -o "$folder/model.ply" --quiet
"$halfline" distance "$folder/scan.ply" --to "$folder/model.ply" --signed --tolerance 0.002 --range 0.02 \
    --picture docs/images/deviation.png --resolution 960,540 --up +Z
