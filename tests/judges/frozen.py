"""Which dataclasses of a package can be written over by who reads them: judged by what is there, whatever is new."""

from dataclasses import is_dataclass
from importlib import import_module
from pkgutil import walk_packages


def dataclasses_of(package):
    """The dataclasses that a package's modules define, by module and name."""
    return {
        f"{module.name}.{name}": each
        for module in walk_packages(package.__path__, f"{package.__name__}.")
        for name, each in vars(import_module(module.name)).items()
        if isinstance(each, type) and is_dataclass(each) and each.__module__ == module.name
    }


def thawed(package):
    """Names of those that are not frozen."""
    return [name for name, each in dataclasses_of(package).items() if not each.__dataclass_params__.frozen]
