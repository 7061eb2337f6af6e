# SPDX-License-Identifier: Apache-2.0
# nix build '.?dir=packaging/nix', in a checkout of the project.
{
  description = "Medial axes and skeletons of 3D shapes";
  inputs.nixpkgs.url = "nixpkgs/nixos-unstable";
  outputs =
    { self, nixpkgs }:
    let
      systems = [ "x86_64-linux" "aarch64-linux" ];
      each = nixpkgs.lib.genAttrs systems;
    in
    {
      packages = each (system: {
        default = nixpkgs.legacyPackages.${system}.callPackage ./package.nix { };
      });
    };
}
