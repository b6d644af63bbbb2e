"""Mappings of the model file, declared by what pydantic's core is to validate.

Pydantic's own classes of models take longer to import and to build than a short motion takes to solve.
"""

from __future__ import annotations

from functools import cache
from typing import Any, ClassVar

from pydantic_core import SchemaValidator, core_schema


class Part:
    """A mapping whose keys are all known: each annotated attribute of a class holds the core schema of its value.

    A key that Python reserves, `from`, is an attribute with a final underscore.
    """

    __slots__ = ("__dict__", "__pydantic_extra__", "__pydantic_fields_set__", "__pydantic_private__")

    fields: ClassVar[dict[str, Any]] = {}
    schema: ClassVar[Any]

    def __init_subclass__(cls) -> None:
        own = {
            name: core_schema.model_field(vars(cls)[name], validation_alias=name.rstrip("_"))
            for name in cls.__annotations__
        }
        cls.fields = {**cls.fields, **own}
        inner = core_schema.model_fields_schema(cls.fields, extra_behavior="forbid")
        cls.schema = core_schema.model_schema(cls, inner, ref=cls.__name__)

    def __init__(self, **given: Any) -> None:
        _validator(type(self)).validate_python(given, self_instance=self)

    @classmethod
    def model_validate(cls, data: dict[str, Any]) -> Any:
        """Return the part that plain data describe; raise ValidationError with all that is wrong."""
        return _validator(cls).validate_python(data)

    @property
    def given(self) -> set[str]:
        """Attributes that the data have."""
        found: set[str] = self.__pydantic_fields_set__  # type: ignore[attr-defined]
        return found


@cache
def _validator(part: type[Part]) -> SchemaValidator:
    return SchemaValidator(part.schema)
