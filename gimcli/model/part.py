"""Base class of the mappings of a model file, validated by pydantic-core.

Pydantic's own BaseModel is not used: its import takes longer than the solution of a short motion.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, Self

from pydantic_core import SchemaValidator, core_schema


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
