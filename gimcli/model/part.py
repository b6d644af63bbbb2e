"""The mappings of a model file: their base class, validated by pydantic-core, and their short forms.

Pydantic's own BaseModel is not used: its import takes longer than the solution of a short motion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Self

from pydantic_core import SchemaValidator, core_schema

MEMBER_WORDS = ("member", "true", "True", "TRUE")
"""Other words for the key `on` of points and loads; programs that read YAML 1.1 write it as true."""


class Part:
    """A mapping with a fixed set of keys.

    Each annotated class attribute declares a key; its value is the pydantic-core schema of the key's value. In an
    instance the attribute holds the validated value. A trailing underscore (`from_`) avoids a reserved word of Python;
    the key in the file has none.
    """

    __slots__ = ("__dict__", "__pydantic_extra__", "__pydantic_fields_set__", "__pydantic_private__")

    fields: ClassVar[dict[str, Any]] = {}
    schema: ClassVar[Any]
    validator: ClassVar[SchemaValidator]
    __pydantic_fields_set__: set[str]

    def __init_subclass__(cls) -> None:
        own = {
            name: core_schema.model_field(vars(cls)[name], validation_alias=name.rstrip("_"))
            for name in cls.__annotations__
        }
        cls.fields = {**cls.fields, **own}
        inner = core_schema.model_fields_schema(cls.fields, extra_behavior="forbid")
        cls.schema = core_schema.model_schema(cls, inner, ref=cls.__name__)
        cls.validator = SchemaValidator(cls.schema)

    def __init__(self, **given: Any) -> None:
        self.validator.validate_python(given, self_instance=self)

    @classmethod
    def model_validate(cls, data: dict[str, Any]) -> Any:
        """Return the part for a dict of plain data; raise pydantic_core.ValidationError that lists all errors."""
        return cls.validator.validate_python(data)

    def with_value(self, key: str, change: Callable[[Any], Any]) -> Self:
        """Return a copy with another value of a key, without validation; `change` returns it from the old one."""
        name = key if key in self.fields else f"{key}_"
        copy: Any = object.__new__(type(self))
        copy.__dict__ = {**self.__dict__, name: change(self.__dict__[name])}
        copy.__pydantic_fields_set__ = self.given | {name}
        copy.__pydantic_extra__ = copy.__pydantic_private__ = None
        own: Self = copy
        return own

    @property
    def given(self) -> set[str]:
        """Names of the keys that were given; the others have their default."""
        return self.__pydantic_fields_set__


# -- short forms ----------------------------------------------------------------------------


def long_form(data: dict[str, Any]) -> dict[str, Any]:
    """Return the data with short forms replaced by long ones, such as [A, B] by {nodes: [A, B]}."""
    result = dict(data)
    for section, long in LONG_PARTS.items():
        if isinstance(result.get(section), dict):
            result[section] = {name: long(part) for name, part in result[section].items()}
    if isinstance(result.get("ground"), list):
        result["ground"] = {"nodes": result["ground"]}
    return {k: v for k, v in result.items() if v is not None or k in ("nodes", "ground")}


def _long_carried(part: Any) -> Any:
    """Return a point or a load with the key `on` in place of the first other word for it; a second word is left."""
    words = [word for word in MEMBER_WORDS if isinstance(part, dict) and word in part]
    if not words or "on" in part:
        return part
    return {"on" if key == words[0] else key: value for key, value in part.items()}


def _alone(key: str, kinds: Any) -> Callable[[Any], Any]:
    """Return the function for parts with a key whose value may stand alone, if it is of some types."""
    return lambda part: {key: part} if isinstance(part, kinds) else part


def _long_actuator(actuator: Any) -> Any:
    if isinstance(actuator, dict) and "effort" in actuator:
        actuator = {**actuator, "effort": _alone("constant", int | float | str)(actuator["effort"])}
    if not isinstance(actuator, dict) or not isinstance(actuator.get("law"), dict):
        return actuator
    law = dict(actuator["law"])
    law |= {"profile": {"name": law["profile"]}} if isinstance(law.get("profile"), str) else {}
    for key in ("polynomial", "table"):  # short forms; more than one of them is reported with the profile
        if key in law and isinstance(own := law.get("profile", {}), dict) and key not in own:
            law["profile"] = {**own, key: law.pop(key)}
    return {**actuator, "law": law}


LONG_PARTS: Mapping[str, Callable[[Any], Any]] = {
    "links": _alone("nodes", list), "elements": _alone("nodes", list), "masses": _alone("mass", int | float | str),
    "friction": _alone("viscous", int | float | str), "points": _long_carried, "loads": _long_carried,
    "actuators": _long_actuator,
}  # fmt: skip
"""The functions that return the long form of a part, by section."""
