"""The packages of the distribution; everything else is in pyproject.toml, which cannot add folders to those found."""

from setuptools import find_packages, setup

setup(
    packages=[*find_packages(include=["gimcli*"]), "gimcli.models", "gimcli.output.page.script"],
    package_dir={"gimcli.models": "models"},
)
