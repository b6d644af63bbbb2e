"""The JSON Schema of the model file, generated from the pydantic-core schemas of its parts."""

from __future__ import annotations

from inspect import cleandoc
from typing import Any

from pydantic.json_schema import GenerateJsonSchema

from gimcli.model.descriptions import PARTS, describe
from gimcli.model.part import Part
from gimcli.model.schema import PROFILES, Model, OpenNode


class Generator(GenerateJsonSchema):
    """Schema generator: names may be numbers, numbers formulas, and the docstring of a part is its description."""

    def float_schema(self, schema: Any) -> dict[str, Any]:
        """Return the schema of a number or a formula."""
        return {**super().float_schema(schema), "type": ["number", "string"]}

    def function_before_schema(self, schema: Any) -> dict[str, Any]:
        """Return the schema of a name."""
        return {"type": ["string", "integer"]}

    def model_schema(self, schema: Any) -> dict[str, Any]:
        """Return the schema of a part."""
        part = schema["cls"]
        own = {"title": part.__name__, "description": cleandoc(part.__doc__), "additionalProperties": False}
        return {**self.generate_inner(schema["schema"]), **own}

    def encode_default(self, dft: Any) -> Any:
        """Return a default as plain data."""
        return vars(dft) if isinstance(dft, Part) else super().encode_default(dft)


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of the model file, including the short forms of its sections."""
    schema = Generator(by_alias=True).generate(Model.schema)
    parts = schema["$defs"]
    names = {"type": "array", "items": {"type": ["string", "integer"]}}
    for section, part in (("links", "Link"), ("elements", "Element")):
        count = {"minItems": 2, "maxItems": 2} if part == "Link" else {"minItems": 3}
        options = [{**names, **count}, {"$ref": f"#/$defs/{part}"}]
        schema["properties"][section]["additionalProperties"] = {"anyOf": options}
    place = schema["properties"]["nodes"]["additionalProperties"]
    sides = {"type": "object", "description": cleandoc(OpenNode.__doc__ or ""), "additionalProperties": False}
    sides["properties"] = {"side": {"enum": ["left", "right"], "description": PARTS["OpenNode"]["side"]}}
    schema["properties"]["nodes"]["additionalProperties"] = {"anyOf": [place, {"type": "null"}, sides]}
    schema["properties"]["ground"] = {"anyOf": [names, {"$ref": "#/$defs/Ground"}]}
    parts["Law"]["properties"]["profile"] = {"anyOf": [{"enum": list(PROFILES)}, {"$ref": "#/$defs/Profile"}]}
    for key in ("polynomial", "table"):
        parts["Law"]["properties"][key] = parts["Profile"]["properties"][key]
    parts["Actuator"]["properties"]["effort"] = {"anyOf": [{"type": ["number", "string"]}, {"$ref": "#/$defs/Effort"}]}
    for section, part in (("masses", "Mass"), ("friction", "PairFriction")):
        one = {"anyOf": [{"type": ["number", "string"]}, {"$ref": f"#/$defs/{part}"}]}
        schema["properties"][section]["additionalProperties"] = one
    for part in ("Tracer", "Load"):
        own = parts[part]
        own["properties"] = {"on": own["properties"]["on"], "member": own["properties"]["on"], **own["properties"]}
        own["required"] = [key for key in own.get("required", ()) if key != "on"]
        own["oneOf"] = [{"required": [key]} for key in ("on", "member")]
    describe(schema)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "gim model file"}
