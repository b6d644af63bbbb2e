"""The packages of the distribution; everything else is in pyproject.toml, which cannot add a folder to those found."""

from setuptools import find_packages, setup

setup(
    packages=[*find_packages(include=["gimcli*"]), "gimcli.models"],
    package_dir={"gimcli.models": "models"},
)
