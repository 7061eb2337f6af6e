# SPDX-License-Identifier: Apache-2.0
# nix-build packaging/nix, without flakes.
{ pkgs ? import <nixpkgs> { } }:
pkgs.callPackage ./package.nix { }
