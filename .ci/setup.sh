#!/usr/bin/env bash
# Finds out what running (`run`) or testing (`test`) needs and this machine lacks, and installs it, or says how.
# Silent when nothing is missing. Exit 1 only when the build itself cannot go on.
set -euo pipefail

purpose="${1:-run}"
case "$purpose" in
run | test) ;;
*)
    echo "usage: $0 run|test" >&2
    exit 2
    ;;
esac

say() { echo "setup: $*" >&2; }

has_program() { command -v "$1" >/dev/null 2>&1; }

# Libraries are opened by name at run time, so a look into the loader's cache and folders is enough.
has_library() {
    local name="$1" folder
    for folder in /usr/lib /usr/lib64 /lib /lib64 /usr/local/lib /usr/lib/*-linux-gnu*; do
        [ -e "$folder/$name" ] && return 0
    done
    # Not `grep -q`: it would end the pipe early, which pipefail takes for a failure.
    { /sbin/ldconfig -p 2>/dev/null || true; } | grep -F "$name" >/dev/null
}

# A driver's description: one that the user chose, or one in the folders where the loader looks.
has_vulkan_driver() {
    local file
    [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] && return 0
    for file in /usr/share/vulkan/icd.d/*.json /etc/vulkan/icd.d/*.json /usr/local/share/vulkan/icd.d/*.json \
        "${XDG_DATA_HOME:-$HOME/.local/share}"/vulkan/icd.d/*.json; do
        [ -e "$file" ] && return 0
    done
    return 1
}

# Tests need the software driver, also where a card has its own.
has_software_driver() {
    local file
    [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] && return 0
    for file in /usr/share/vulkan/icd.d/lvp_icd*.json /etc/vulkan/icd.d/lvp_icd*.json; do
        [ -e "$file" ] && return 0
    done
    return 1
}

case "$(uname -s)" in
Linux) ;;
Darwin)
    has_program cc || { say 'no C compiler: run xcode-select --install'; exit 1; }
    has_program cargo || { say 'no Rust: see https://rustup.rs'; exit 1; }
    exit 0
    ;;
*)
    has_program cargo || { say 'no Rust: see https://rustup.rs'; exit 1; }
    exit 0
    ;;
esac

missing=() # Debian's packages
need() { missing+=("$@"); }

has_program cc || need gcc libc6-dev
has_program c++ || need g++
has_library libvulkan.so.1 || need libvulkan1
has_vulkan_driver || need mesa-vulkan-drivers
# A machine without a display draws to a file and needs no window libraries.
if [ "$purpose" = test ] || [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]; then
    while read -r library package; do
        has_library "$library" || need "$package"
    done <<'LIBRARIES'
libX11.so.6 libx11-6
libX11-xcb.so.1 libx11-xcb1
libXcursor.so.1 libxcursor1
libXi.so.6 libxi6
libXrandr.so.2 libxrandr2
libxkbcommon.so.0 libxkbcommon0
libxkbcommon-x11.so.0 libxkbcommon-x11-0
libwayland-client.so.0 libwayland-client0
LIBRARIES
fi
if [ "$purpose" = test ]; then
    has_software_driver || [[ " ${missing[*]-} " == *' mesa-vulkan-drivers '* ]] || need mesa-vulkan-drivers
    has_program Xvfb || need xvfb
    has_program xdotool || need xdotool
fi

if [ "${#missing[@]}" -gt 0 ]; then
    say "missing here: ${missing[*]}"
    if has_program apt-get; then
        install=(apt-get install -y --no-install-recommends "${missing[@]}")
        as_root=()
        if [ "$(id -u)" -ne 0 ]; then
            if has_program sudo && sudo -n true 2>/dev/null; then as_root=(sudo -n); else as_root=(none); fi
        fi
        if [ "${as_root[*]-}" = none ]; then
            say "installing needs root; run: sudo apt-get update && sudo ${install[*]}"
        else
            say 'installing them'
            export DEBIAN_FRONTEND=noninteractive
            # Package lists may be missing or old; the install says what is really wrong.
            "${as_root[@]}" apt-get update -qq >&2 || true
            "${as_root[@]}" "${install[@]}" >&2 || say "that failed; run: sudo apt-get update && sudo ${install[*]}"
        fi
    elif has_program dnf; then
        say 'run: sudo dnf install gcc gcc-c++ vulkan-loader mesa-vulkan-drivers libX11 libX11-xcb libXcursor libXi libXrandr libxkbcommon libxkbcommon-x11 libwayland-client xorg-x11-server-Xvfb xdotool'
    elif has_program pacman; then
        say 'run: sudo pacman -S --needed base-devel vulkan-icd-loader vulkan-swrast libx11 libxcursor libxi libxrandr libxkbcommon libxkbcommon-x11 wayland xorg-server-xvfb xdotool'
    elif has_program brew; then
        say 'run: brew install gcc vulkan-loader mesa'
    else
        say "install, with this system's package manager: a C and a C++ compiler, the Vulkan loader and a driver (Mesa), the X11 client libraries, Xvfb, xdotool"
    fi
fi

# Without these nothing can be built; anything else leaves a program that says what it misses.
has_program cc || { say 'there is still no C compiler (cc), which Rust links with'; exit 1; }
has_program c++ || { say 'there is still no C++ compiler (c++), which the image error FLIP is built with'; exit 1; }
has_program cargo || { say 'there is no Rust: see https://rustup.rs'; exit 1; }
if [ "$purpose" = test ] && ! { has_program Xvfb && has_program xdotool && has_software_driver; }; then
    say 'the tests cannot run without Xvfb, xdotool and a software Vulkan driver'
    exit 1
fi
