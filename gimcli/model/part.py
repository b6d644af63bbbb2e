"""A mapping of the model file, declared by what pydantic's core validates.

Pydantic's own model classes take longer to import and to build than a short motion takes to solve.
"""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic_core import SchemaValidator, core_schema


class Part:
    """A mapping whose keys are all known: each annotated attribute of a class is the core schema of its value.

    An attribute with a final underscore is a key that is a word of Python, such as `from`.
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
        """Return the part that plain data describe; raise ValidationError with all that is wrong."""
        return cls.validator.validate_python(data)

    @property
    def given(self) -> set[str]:
        """Attributes that the data have."""
        return self.__pydantic_fields_set__
