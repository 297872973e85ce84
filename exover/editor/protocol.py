"""JSON-RPC of the language server: each request gets a response, each bad message an error (LSP 3.17)."""

from typing import Any
from urllib.parse import unquote

from lsprotocol import types
from pygls.exceptions import (
    JsonRpcException,
    JsonRpcInvalidParams,
    JsonRpcInvalidRequest,
    JsonRpcParseError,
    JsonRpcServerNotInitialized,
)
from pygls.protocol import LanguageServerProtocol

from exover.dataclass import dataclass

_OF_OPEN_DOCUMENTS = frozenset(
    {types.TEXT_DOCUMENT_DID_CHANGE, types.TEXT_DOCUMENT_DID_SAVE, types.TEXT_DOCUMENT_DID_CLOSE}
)


@dataclass(frozen=True, slots=True)
class RefusedMessage:
    """A message that is refused. `number`: the id of the response; None if it is not known.

    `answered`: whether it gets a response; notifications and responses get none.
    """

    error: JsonRpcException
    number: int | str | None = None
    answered: bool = True


class SpecProtocol(LanguageServerProtocol):
    """The protocol of pygls, except that each bad request is answered, and bad notifications are silently dropped."""

    def structure_message(self, data: dict[str, Any]) -> Any:
        """Return a message as a value, or `RefusedMessage`; an object without `jsonrpc`, as one inside, as it is."""
        if "jsonrpc" not in data:
            return data
        number, asked = _number(data), "id" in data
        if "method" not in data:
            asked = asked and not data.keys() & {"result", "error"}
        elif asked and number is None:
            return RefusedMessage(JsonRpcInvalidRequest("`id` is no number and no string"))
        try:
            return super().structure_message(data if "method" not in data else {"params": None, **data})
        except JsonRpcException as error:
            understood = isinstance(error, JsonRpcInvalidParams) and "method" in data
            return RefusedMessage(error if understood else JsonRpcInvalidRequest(), number, asked)

    def handle_message(self, message: Any) -> None:
        """Handle a message; refuse it if it cannot be read, or comes before `initialize` or after `shutdown`."""
        refused = message if isinstance(message, RefusedMessage) else self._refused(message)
        if refused is None:
            super().handle_message(message)
        elif refused.answered:
            self.refuse(refused)

    def refuse(self, refused: RefusedMessage) -> None:
        """Send the error response to a refused message."""
        error = refused.error.to_response_error()
        self._send_data({"jsonrpc": self.VERSION, "id": refused.number, "error": error})

    def _refused(self, message: Any) -> RefusedMessage | None:
        """Return the refusal of a message; None if it is to be handled."""
        if not hasattr(message, "jsonrpc"):
            return RefusedMessage(JsonRpcInvalidRequest("no message of JSON-RPC 2.0"), _number(message))
        method, number = getattr(message, "method", ""), getattr(message, "id", None)
        fault = self._fault(message, method)
        return RefusedMessage(fault, number, bool(method) and number is not None) if fault else None

    def _fault(self, message: Any, method: str) -> JsonRpcException | None:
        if message.jsonrpc != self.VERSION:
            return JsonRpcInvalidRequest("`jsonrpc` is not 2.0")
        if method == types.EXIT or not method:
            return None
        if self._workspace is None and method != types.INITIALIZE:
            return JsonRpcServerNotInitialized("`initialize` comes first")
        if self._workspace is not None and method == types.INITIALIZE:
            return JsonRpcInvalidRequest("`initialize` comes once")
        if self._shutdown:
            return JsonRpcInvalidRequest("nothing but `exit` comes after `shutdown`")
        if method in _OF_OPEN_DOCUMENTS and not self._is_open(message.params.text_document.uri):
            return JsonRpcInvalidParams("the document is not open")
        return None

    def _is_open(self, uri: str) -> bool:
        return unquote(uri) in self.workspace.text_documents  # pygls keeps them so


def _number(message: Any) -> int | str | None:
    """Return the id of a message; None if it has none, or one that is neither a number nor a string."""
    number = message.get("id") if isinstance(message, dict) else None
    return number if isinstance(number, int | str) else None


def unreadable(error: Exception) -> RefusedMessage | None:
    """Return the refusal of bytes that are no JSON, by the error of reading them; None for another error."""
    if isinstance(error, ValueError | RecursionError):
        return RefusedMessage(JsonRpcParseError("no JSON in UTF-8"))
    return None
