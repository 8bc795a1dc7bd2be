"""Parts of a configuration that most benches have not: their models are imported when there is one."""

from collections.abc import Callable
from typing import Any

from pydantic import BaseModel, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema
from pydantic_core.core_schema import no_info_plain_validator_function


class LazyModel:
    """Metadata of an annotation whose model ``load`` imports: errors, their places and what the JSON Schema
    takes are as if the model stood there."""

    def __init__(self, load: Callable[[], type[BaseModel]]) -> None:
        self.load = load

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return no_info_plain_validator_function(lambda value: self.load().model_validate(value))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        model = self.load()
        model.model_rebuild()
        return handler(model.__pydantic_core_schema__)
