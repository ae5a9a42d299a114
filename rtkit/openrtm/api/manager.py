"""The manager as modules of OpenRTM-aist see it: registers what they offer.

While a module is loaded nothing is created: that is for whoever asked for the module.
"""

from __future__ import annotations

from collections.abc import Callable
from contextvars import ContextVar
from typing import Any, ClassVar, Protocol

from rtkit.openrtm.absent import refuse
from rtkit.openrtm.api.adapter import HeldComponent, held_class, living
from rtkit.openrtm.api.logger import Logger
from rtkit.openrtm.api.properties import Properties
from rtkit.openrtm.corba.object_broker import ObjectAdapter, ObjectRequestBroker


class Registrar(Protocol):
    """The part of a manager of rtkit that init functions use."""

    def register_factory(self, component: type[HeldComponent]) -> object:
        """Make a component type available."""


def Delete(component: Any) -> None:
    """Do nothing: rtkit deletes components itself."""


class _Nothing:
    """Stands for a component that an init function would create: takes every call."""

    def __getattr__(self, name: str) -> Any:
        return self

    def __call__(self, *_: Any, **__: Any) -> Any:
        return self

    def __getitem__(self, _: Any) -> Any:
        return self

    def __iter__(self) -> Any:
        return iter(())


class EndOfMain(BaseException):
    """Leaves the main function of a module where it would run its manager."""


class ModuleManager:
    """The manager that an init function gets, and ``Manager.instance()`` of its module."""

    def __init__(self, registrar: Registrar | None = None) -> None:
        self._registrar = registrar
        self._config = Properties()
        self._begin: Callable[[Any], object] | None = None

    def run_main(self, main: Callable[[], object]) -> None:
        """Have a main function register, up to where it would run its manager."""
        token = _of_main.set(self)
        try:
            main()
        except EndOfMain:
            pass
        finally:
            _of_main.reset(token)

    def setModuleInitProc(self, proc: Callable[[Any], object]) -> None:
        """Have a function called when the manager is activated."""
        self._begin = proc

    def activateManager(self) -> bool:
        """Have the function called that registers."""
        if self._begin is not None:
            self._begin(self)
        return True

    def runManager(self, no_block: bool | None = None) -> None:
        """Leave the main function: what comes behind is for a process of its own."""
        raise EndOfMain

    def registerFactory(self, profile: Properties, new_func: Any, delete_func: Any = None) -> bool:
        """Offer a component class for creation."""
        if self._registrar is None:
            raise refuse("Manager.registerFactory after the module was loaded")
        self._registrar.register_factory(held_class(new_func, profile.texts(), Manager.instance()))
        return True

    def createComponent(self, comp_args: str) -> Any:
        """Create nothing while a module is loaded."""
        if self._registrar is None:
            raise refuse(f"Manager.createComponent({comp_args!r}) from within a component")
        return _Nothing()

    def getComponents(self) -> list[Any]:
        """Return the objects of the components of this process."""
        return [each.servant for each in living()]

    def getComponent(self, instance_name: str) -> Any:
        """Return the object of a component of this process; None where there is none."""
        found = (each.servant for each in living() if each.instance == instance_name)
        return next(found, None)

    def getLogbuf(self, name: str = "manager") -> Logger:
        """Return a logger."""
        return Logger(name)

    def getConfig(self) -> Properties:
        """Return its properties, of which a component sees none."""
        return self._config

    def getPOA(self) -> ObjectAdapter:
        """Return the object adapter."""
        return ObjectAdapter()

    def getORB(self) -> ObjectRequestBroker:
        """Return the object request broker."""
        return ObjectRequestBroker()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        raise refuse(f"Manager.{name}")


_of_main: ContextVar[ModuleManager | None] = ContextVar("_of_main", default=None)
"""The manager of the module whose main function runs, so that it registers."""


class Manager:
    """``OpenRTM_aist.Manager``.

    Attributes:
        begin: Starts a manager for a module that is run as a script; set by what runs it.
    """

    begin: ClassVar[Callable[[list[str]], ModuleManager] | None] = None
    _instance: ClassVar[ModuleManager] = ModuleManager()

    @classmethod
    def instance(cls) -> ModuleManager:
        """Return the manager of this process."""
        return cls._instance

    @classmethod
    def init(cls, *arguments: Any) -> ModuleManager:
        """Start, or join, a manager for a module that is run as a script."""
        loading = _of_main.get()
        if loading is not None:
            return loading
        argv = next((list(each) for each in arguments if isinstance(each, (list, tuple))), [])
        if cls.begin is None:
            raise refuse("Manager.init in a module that a manager loads")
        cls._instance = cls.begin(argv)
        return cls._instance
